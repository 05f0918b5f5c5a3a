#include "devices/hardware/kinematics.hpp"

#include <cmath>

#include "framework/core/check.hpp"

namespace tactor {

LinearKinematics::LinearKinematics(const std::vector<Vec3>& directions_B) {
  if (directions_B.empty() || directions_B.size() > 3) {
    throw InputError("expected 1 to 3 directions of sliding axes, found " + std::to_string(directions_B.size()));
  }
  for (const Vec3& direction : directions_B) {
    const double length = norm(direction);
    if (!(length > 1e-9) || !std::isfinite(length)) {
      throw InputError("expected a direction of an axis with a length above zero, found a vector of length zero");
    }
    const Vec3 unit = (1.0 / length) * direction;
    for (const Vec3& other : directions_B_) {
      if (std::abs(dot(unit, other)) > 1e-6) {
        throw InputError("expected directions of axes at right angles to one another, found two that are not");
      }
    }
    directions_B_.push_back(unit);
  }
}

bool LinearKinematics::forward(const AxisValues& q, Pose& X_BD) noexcept {
  X_BD = {};
  for (std::size_t i = 0; i < directions_B_.size(); ++i) X_BD.p += q[i] * directions_B_[i];
  return is_finite(X_BD.p);
}

void LinearKinematics::efforts(const AxisValues&, const Wrench& F_D_B, AxisValues& effort) noexcept {
  effort = {};
  for (std::size_t i = 0; i < directions_B_.size(); ++i) effort[i] = dot(directions_B_[i], F_D_B.force);
}

}  // namespace tactor
