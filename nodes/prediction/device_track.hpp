// Where the device was during its last 1024 ticks (a quarter of a second at 4 kHz), and what a predictor declares to
// know it.
#pragma once

#include "framework/node/declare.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/prediction/sample_window.hpp"

namespace tactor {

/// The last poses of the device. States that are not finite, or not later than the one before, are left out.
class DeviceTrack {
 public:
  void read(Input<DeviceState>& device) {
    Stamped<DeviceState> state;
    while (new_states_.next(device, state)) {
      const Pose& X = state.value.X_WD;
      const bool later = poses_.size() == 0 || state.stamp.valid > poses_[0].stamp.valid;
      const bool finite = is_finite(X.p) && is_finite(Vec3{X.R.x, X.R.y, X.R.z}) && std::isfinite(X.R.w);
      if (later && finite) poses_.push({state.stamp, X});
    }
  }
  /// The pose at time t, interpolated between its neighbours; the newest where t is later. False where t is before
  /// all that is remembered.
  [[nodiscard]] bool at(Time t, Pose& X_WD) const {
    SamplePlace place;
    if (!find_place(poses_, t, place)) return false;
    X_WD = poses_[place.age].value;
    if (place.age == 0) return true;
    X_WD = between(X_WD, poses_[place.age - 1].value, place.share);
    return true;
  }

 private:
  static constexpr std::size_t capacity = 1024;
  NewMessages<DeviceState> new_states_;
  SampleWindow<Stamped<Pose>> poses_{capacity};
};

/// The way from one pose to another: in force's place the translation in m, in torque's the rotation vector in rad,
/// both in W, so that each part of a wrench finds its own.
inline Wrench displacement(const Pose& from, const Pose& to) {
  return {to.p - from.p, to_rotation_vector(to.R * inverse(from.R))};
}

/// Adds the input `device`.
template <class N>
Declare<N>& declare_device_track(Declare<N>& node) {
  return node.input("device", &N::device,
                    {.doc = "the device's state at its own rate", .queue = {QueuePolicy::drop_oldest, 1024}});
}

}  // namespace tactor
