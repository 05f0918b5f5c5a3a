// What a device showed of its handle, paired with what it commanded, in the order of their times.
#pragma once

#include <cmath>

#include "framework/core/messages.hpp"
#include "framework/node/new_messages.hpp"

namespace tactor {

/// A node at a port has two inputs: every sample of the handle, and every wrench that the device commands. A wrench of
/// the time of a sample acts from that sample on. So before a sample come the wrenches of earlier times, and after the
/// newest sample all that are there. A sample or a wrench that is not finite is left out, and so is a sample that is
/// not later than the one before.
class PortSamples {
 public:
  /// Calls `on_wrench(const Wrench&)` and `on_sample(const Stamped<DeviceState>&)` for all that has come. Before and in
  /// `on_sample`, `newest()` is the sample before that one.
  template <class OnWrench, class OnSample>
  void take(Input<DeviceState>& device, Input<Wrench>& commanded, OnWrench on_wrench, OnSample on_sample) {
    Stamped<DeviceState> sample;
    while (samples_.next(device, sample)) {
      take_wrenches(commanded, &sample.stamp.valid, on_wrench);
      if (!is_finite_sample(sample.value) || (started_ && sample.stamp.valid <= newest_.stamp.valid)) continue;
      on_sample(sample);
      newest_ = sample;
      started_ = true;
    }
    take_wrenches(commanded, nullptr, on_wrench);
  }

  /// True when a sample has come.
  [[nodiscard]] bool started() const { return started_; }
  [[nodiscard]] const Stamped<DeviceState>& newest() const { return newest_; }

 private:
  /// Those before `end`; all where it is null.
  template <class OnWrench>
  void take_wrenches(Input<Wrench>& commanded, const Time* end, OnWrench& on_wrench) {
    for (;;) {
      if (!has_next_) has_next_ = wrenches_.next(commanded, next_);
      if (!has_next_ || (end != nullptr && next_.stamp.valid >= *end)) return;
      if (is_finite(next_.value)) on_wrench(next_.value);
      has_next_ = false;
    }
  }
  static bool is_finite_sample(const DeviceState& s) {
    const Quat& R = s.X_WD.R;
    return is_finite(s.X_WD.p) && is_finite(s.V_WD.v) && is_finite(s.V_WD.w) && std::isfinite(R.w + R.x + R.y + R.z);
  }

  NewMessages<DeviceState> samples_;
  NewMessages<Wrench> wrenches_;
  Stamped<Wrench> next_;  // the next wrench to be told of, where `has_next_`
  bool has_next_ = false;
  bool started_ = false;
  Stamped<DeviceState> newest_;
};

}  // namespace tactor
