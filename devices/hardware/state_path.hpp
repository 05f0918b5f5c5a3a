// The states that a device showed in a run, for the device of the reference run to go along.
#pragma once

#include <algorithm>
#include <vector>

#include "framework/core/between_samples.hpp"
#include "framework/realtime/device_node.hpp"

namespace tactor {

/// States in the order of their times, within the room made for them.
class StatePath {
 public:
  /// Room for `run` at `rate` Hz, or for half an hour at 1 kHz if that is less. None if the run goes on until it is
  /// stopped, because no reference run follows it.
  StatePath(Duration run, double rate) {
    constexpr double most = 2e6;
    if (run == until_stopped) return;
    samples_.resize(static_cast<std::size_t>(std::min(run.seconds() * rate + 2, most)));
    samples_.clear();
  }
  /// Adds a sample that is later than the newest, where there is room. Allocates nothing.
  void add(const DeviceSample& sample) noexcept {
    if (samples_.size() == samples_.capacity() || (!samples_.empty() && samples_.back().time >= sample.time)) return;
    samples_.push_back(sample);
  }
  [[nodiscard]] bool empty() const { return samples_.empty(); }
  /// The state at `now`, which never decreases from call to call: the pose between two samples, the rest that of the
  /// earlier one. Needs a sample.
  [[nodiscard]] DeviceState at(Time now) noexcept {
    const Pose X_WD = value_between(samples_, now, leg_, &DeviceSample::time,
                                    [](const DeviceSample& sample) { return sample.state.X_WD; });
    DeviceState state = samples_[leg_].state;
    state.X_WD = X_WD;
    return state;
  }

 private:
  std::vector<DeviceSample> samples_;
  std::size_t leg_ = 0;
};

}  // namespace tactor
