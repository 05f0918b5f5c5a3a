#include "devices/falcon/delta_arm.hpp"

#include <cmath>

namespace tactor {

namespace {

constexpr Vec3 middle{0, 0, 0.12};  // m, of the Falcon's workspace
constexpr int most_iterations = 30;
constexpr double longest_step = 0.02;   // m
constexpr double close_enough = 1e-12;  // m

}  // namespace

std::optional<Vec3> solve(const std::array<Vec3, 3>& rows, const std::array<double, 3>& right) {
  const Vec3 yz = cross(rows[1], rows[2]), zx = cross(rows[2], rows[0]), xy = cross(rows[0], rows[1]);
  const double determinant = dot(rows[0], yz);
  const double size = norm(rows[0]) * norm(rows[1]) * norm(rows[2]);
  if (!(std::abs(determinant) > 1e-9 * size)) return std::nullopt;
  return (1.0 / determinant) * (right[0] * yz + right[1] * zx + right[2] * xy);
}

DeltaArm::Closure DeltaArm::closure(int arm, double theta, const Vec3& p_BD) const {
  const double phi = g_.phi[static_cast<std::size_t>(arm)];
  const double cos_phi = std::cos(phi), sin_phi = std::sin(phi);
  const double u = cos_phi * p_BD.x + sin_phi * p_BD.y - g_.r;
  const double v = -sin_phi * p_BD.x + cos_phi * p_BD.y - g_.s;
  const double U = u + g_.c - g_.a * std::cos(theta);
  const double W = p_BD.z - g_.a * std::sin(theta);
  const double V = v + g_.f;
  const double rho = std::hypot(U, W);
  const double over = rho - g_.d - g_.e;
  const double gu = 2 * over * U / rho, gw = 2 * over * W / rho, gv = 2 * V;
  Closure c;
  c.value = over * over + V * V - g_.b * g_.b;
  c.by_p = {gu * cos_phi - gv * sin_phi, gu * sin_phi + gv * cos_phi, gw};
  c.by_theta = g_.a * (gu * std::sin(theta) - gw * std::cos(theta));
  return c;
}

std::optional<Vec3> DeltaArm::forward(const std::array<double, 3>& theta) const {
  Vec3 p = middle;
  for (int round = 0; round < most_iterations; ++round) {
    std::array<Vec3, 3> rows;
    std::array<double, 3> right{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Closure c = closure(static_cast<int>(i), theta[i], p);
      rows[i] = c.by_p;
      right[i] = -c.value;
    }
    const auto step = solve(rows, right);
    if (!step || !is_finite(*step)) return std::nullopt;
    p += limited(*step, longest_step);
    if (norm(*step) < close_enough) {
      // The other place, with the handle behind its base, is none.
      if (p.z > 0) return p;
      return std::nullopt;
    }
  }
  return std::nullopt;
}

std::optional<std::array<double, 3>> DeltaArm::inverse(const Vec3& p_BD) const {
  std::array<double, 3> theta{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double cos_phi = std::cos(g_.phi[i]), sin_phi = std::sin(g_.phi[i]);
    const double u = cos_phi * p_BD.x + sin_phi * p_BD.y - g_.r + g_.c;
    const double V = -sin_phi * p_BD.x + cos_phi * p_BD.y - g_.s + g_.f;
    const double w = p_BD.z;
    const double shin = g_.b * g_.b - V * V;
    if (!(shin > 0)) return std::nullopt;
    const double rho = std::sqrt(shin) + g_.d + g_.e;
    // Circles of radius a about the arm's base and rho about the handle meet at the knee:
    // u cos theta + w sin theta = (u^2 + w^2 + a^2 - rho^2) / (2 a), the knee on the outer side.
    const double distance = std::hypot(u, w);
    const double cosine = (u * u + w * w + g_.a * g_.a - rho * rho) / (2 * g_.a * distance);
    if (!(std::abs(cosine) <= 1)) return std::nullopt;
    theta[i] = std::atan2(w, u) - std::acos(cosine);
  }
  return theta;
}

std::optional<std::array<Vec3, 3>> DeltaArm::rates(const std::array<double, 3>& theta, const Vec3& p_BD) const {
  std::array<Vec3, 3> rows;
  for (std::size_t i = 0; i < 3; ++i) {
    const Closure c = closure(static_cast<int>(i), theta[i], p_BD);
    if (!(std::abs(c.by_theta) > 1e-9 * g_.a * g_.b)) return std::nullopt;
    rows[i] = (-1.0 / c.by_theta) * c.by_p;
  }
  return rows;
}

std::optional<std::array<Vec3, 3>> DeltaArm::jacobian(const std::array<double, 3>& theta, const Vec3& p_BD) const {
  const auto K = rates(theta, p_BD);
  if (!K) return std::nullopt;
  std::array<Vec3, 3> columns;
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<double, 3> unit{};
    unit[i] = 1;
    const auto column = solve(*K, unit);
    if (!column || !is_finite(*column)) return std::nullopt;
    columns[i] = *column;
  }
  return columns;
}

std::optional<std::array<double, 3>> DeltaArm::torques(const std::array<double, 3>& theta, const Vec3& p_BD,
                                                       const Vec3& F_B) const {
  const auto J = jacobian(theta, p_BD);
  if (!J) return std::nullopt;
  return std::array<double, 3>{dot((*J)[0], F_B), dot((*J)[1], F_B), dot((*J)[2], F_B)};
}

}  // namespace tactor
