#include "devices/usb/wooden_arm.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

Vec3 WoodenArm::forward(const std::array<double, 3>& q) const {
  const double reach = g_.Lb * std::sin(q[1]) + g_.Lc * std::sin(q[2]);
  const double height = g_.La + g_.Lb * std::cos(q[1]) - g_.Lc * std::cos(q[2]);
  return Vec3{std::cos(q[0]) * reach, std::sin(q[0]) * reach, height} - g_.O;
}

std::array<Vec3, 3> WoodenArm::jacobian(const std::array<double, 3>& q) const {
  const double cA = std::cos(q[0]), sA = std::sin(q[0]);
  const double reach = g_.Lb * std::sin(q[1]) + g_.Lc * std::sin(q[2]);
  const double b = g_.Lb * std::cos(q[1]), c = g_.Lc * std::cos(q[2]);
  return {Vec3{-sA * reach, cA * reach, 0}, Vec3{cA * b, sA * b, -g_.Lb * std::sin(q[1])},
          Vec3{cA * c, sA * c, g_.Lc * std::sin(q[2])}};
}

std::optional<std::array<double, 3>> WoodenArm::inverse(const Vec3& p_BD) const {
  const Vec3 p = p_BD + g_.O;
  const double reach = std::hypot(p.x, p.y), height = p.z - g_.La;
  const double distance = std::hypot(reach, height);
  if (!(distance > 0) || !(distance <= g_.Lb + g_.Lc) || !(distance >= std::abs(g_.Lb - g_.Lc))) return std::nullopt;
  // The triangle of both links in the plane of the arm; angles against the vertical.
  const double cosine = (g_.Lb * g_.Lb + distance * distance - g_.Lc * g_.Lc) / (2 * g_.Lb * distance);
  const double lean = std::atan2(reach, height) - std::acos(std::min(1.0, std::max(-1.0, cosine)));
  const double out = reach - g_.Lb * std::sin(lean), down = g_.Lb * std::cos(lean) - height;
  return std::array<double, 3>{std::atan2(p.y, p.x), lean, std::atan2(out, down)};
}

}  // namespace tactor
