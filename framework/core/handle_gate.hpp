// Which samples of the handle physics can be stepped through.
#pragma once

#include <cmath>
#include <optional>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"

namespace tactor {

/// True where a step can go to that sample of the handle, once its rotation is normalised.
inline bool is_usable(const DeviceState& s) {
  const Quat& q = s.X_WD.R;
  const double length = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return is_finite(s.X_WD.p) && is_finite(s.V_WD.v) && is_finite(s.V_WD.w) && std::isfinite(length) && length > 0.25;
}

/// Admits the samples of the handle that can be stepped to, in the order of their times, and counts all that come.
class HandleGate {
 public:
  /// Normalises the sample's rotation. False, and nothing changes, where the sample is not finite, or no later than the
  /// last one admitted.
  bool admit(Stamped<DeviceState>& sample) {
    const RefusalReason refusal = !is_usable(sample.value)                        ? RefusalReason::not_finite
                                  : admitted_ && sample.stamp.valid <= *admitted_ ? RefusalReason::late
                                                                                  : RefusalReason::none;
    refused_.count(refusal);
    if (refusal != RefusalReason::none) return false;
    sample.value.X_WD.R = normalized(sample.value.X_WD.R);
    admitted_ = sample.stamp.valid;
    return true;
  }
  [[nodiscard]] const Refusals& refusals() const { return refused_; }

 private:
  std::optional<Time> admitted_;  // time of the last one
  Refusals refused_{"samples"};
};

}  // namespace tactor
