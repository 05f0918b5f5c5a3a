// The samples of the handle as dynamics steps through them.
#pragma once

#include "framework/core/handle_gate.hpp"
#include "framework/node/port.hpp"

namespace tactor {

/// Reads the samples of the handle that HandleGate admits, up to a time. The first later one waits.
class HandleSamples {
 public:
  /// Puts the next one up to `until` into `sample`; false where there is none.
  bool next(Input<DeviceState>& device, Time until, Stamped<DeviceState>& sample) {
    while (waiting_ || device.pop(next_)) {
      waiting_ = next_.stamp.valid > until;
      if (waiting_) return false;
      if (!gate_.admit(next_)) continue;
      sample = next_;
      return true;
    }
    return false;
  }
  [[nodiscard]] const Refusals& refusals() const { return gate_.refusals(); }

 private:
  HandleGate gate_;
  Stamped<DeviceState> next_;
  bool waiting_ = false;  // next_ does
};

}  // namespace tactor
