// From the coordinates of a device's axes to the pose of its handle, and from a wrench to the efforts of the axes.
#pragma once

#include <vector>

#include "devices/hardware/link.hpp"
#include "framework/core/spatial.hpp"

namespace tactor {

/// The geometry of a device with base B and handle D. One thread uses it; nothing in it allocates, waits or throws.
class Kinematics {
 public:
  Kinematics() = default;
  virtual ~Kinematics() = default;
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  /// The number of axes, 1 to max_axes.
  [[nodiscard]] virtual int axes() const = 0;
  /// m that the handle goes for a m or rad of an axis, at least, in the poses in which the device is used.
  [[nodiscard]] virtual double lever() const = 0;
  /// The pose of the handle in the base, X_BD, where the axes are at `q` (m, rad). False where no pose belongs to them.
  virtual bool forward(const AxisValues& q, Pose& X_BD) noexcept = 0;
  /// The efforts J^T F (N, N m) that put the wrench `F_D_B` (on the device, in B, about the handle) to the handle.
  virtual void efforts(const AxisValues& q, const Wrench& F_D_B, AxisValues& effort) noexcept = 0;
};

/// One to three sliding axes: p_BD = sum_i q_i d_i with unit directions d_i in B, so effort_i = d_i . F. The handle
/// does not turn. Of a wrench a device of fewer than three axes renders the part along them.
class LinearKinematics final : public Kinematics {
 public:
  /// One direction an axis, of any length above zero; throws InputError for another number of them, and for directions
  /// that are not at right angles, whose efforts would add up to more than the wrench.
  explicit LinearKinematics(const std::vector<Vec3>& directions_B);

  [[nodiscard]] int axes() const override { return static_cast<int>(directions_B_.size()); }
  [[nodiscard]] double lever() const override { return 1; }
  bool forward(const AxisValues& q, Pose& X_BD) noexcept override;
  void efforts(const AxisValues& q, const Wrench& F_D_B, AxisValues& effort) noexcept override;

 private:
  std::vector<Vec3> directions_B_;
};

}  // namespace tactor
