// The geometry of WoodenHaptics as the kinematics of a device.
#pragma once

#include "devices/hardware/kinematics.hpp"
#include "devices/usb/wooden_arm.hpp"

namespace tactor {

/// The handle's place; its orientation is not measured and stays that of the base.
class WoodenKinematics final : public Kinematics {
 public:
  explicit WoodenKinematics(const WoodenGeometry& geometry) : arm_(geometry) {}
  [[nodiscard]] int axes() const override { return 3; }
  [[nodiscard]] double lever() const override { return 0.1; }
  bool forward(const AxisValues& q, Pose& X_BD) noexcept override {
    X_BD = {arm_.forward({q[0], q[1], q[2]}), {}};
    return is_finite(X_BD.p);
  }
  void efforts(const AxisValues& q, const Wrench& F_D_B, AxisValues& effort) noexcept override {
    const auto J = arm_.jacobian({q[0], q[1], q[2]});
    effort = {};
    for (std::size_t i = 0; i < 3; ++i) effort[i] = dot(J[i], F_D_B.force);
  }

 private:
  WoodenArm arm_;
};

}  // namespace tactor
