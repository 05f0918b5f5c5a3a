// The Falcon's geometry as the kinematics of a device.
#pragma once

#include "devices/falcon/delta_arm.hpp"
#include "devices/hardware/kinematics.hpp"

namespace tactor {

/// The handle's place; it does not turn.
class DeltaKinematics final : public Kinematics {
 public:
  [[nodiscard]] int axes() const override { return 3; }
  [[nodiscard]] double lever() const override { return 0.05; }
  bool forward(const AxisValues& q, Pose& X_BD) noexcept override {
    const auto p = arm_.forward({q[0], q[1], q[2]});
    if (p) X_BD = {*p, {}};
    return p.has_value();
  }
  /// Zero where the arms are stretched so far that torques hold no force.
  void efforts(const AxisValues& q, const Wrench& F_D_B, AxisValues& effort) noexcept override {
    effort = {};
    const std::array<double, 3> theta{q[0], q[1], q[2]};
    const auto p = arm_.forward(theta);
    const auto torques = p ? arm_.torques(theta, *p, F_D_B.force) : std::nullopt;
    for (std::size_t i = 0; torques && i < 3; ++i) effort[i] = (*torques)[i];
  }

 private:
  DeltaArm arm_;
};

}  // namespace tactor
