#include "devices/simulated/handle.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactor {

namespace {

using Matrix3 = std::array<std::array<double, 3>, 3>;

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 3; ++j) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

/// exp(a) by scaling and squaring of its Taylor series; 14 terms are exact in double for a norm up to 1/4.
Matrix3 exponential(Matrix3 a) {
  double size = 0;
  for (const auto& row : a) size = std::max(size, std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]));
  int halvings = 0;
  for (; size > 0.25 && halvings < 60; size *= 0.5) ++halvings;
  for (auto& row : a) {
    for (double& entry : row) entry = std::ldexp(entry, -halvings);
  }
  const Matrix3 one{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Matrix3 sum = one;
  // Horner: 1 + a (1 + a/2 (1 + a/3 (...))).
  for (int n = 14; n >= 1; --n) {
    sum = product(a, sum);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) sum[i][j] = sum[i][j] / n + one[i][j];
    }
  }
  for (; halvings > 0; --halvings) sum = product(sum, sum);
  return sum;
}

/// `v` after an impulse of friction that takes at most `loss` of its norm.
Vec3 slowed(const Vec3& v, double loss) {
  const double speed = norm(v);
  return speed <= loss ? Vec3{} : (1.0 - loss / speed) * v;
}

}  // namespace

Handle::Handle(const HandleParameters& translation, const HandleParameters& rotation, double sub_step, bool rotate)
    : translation_(translation), rotation_(rotation), sub_step_(sub_step), rotate_(rotate) {}

Handle::Propagator Handle::make_propagator(const HandleParameters& coupling, double h) {
  // d/dt (x, v, f) = (v, (f - K x - B v) / M, 0).
  const double damping = coupling.damping + coupling.hand_damping;
  const Matrix3 step = exponential(
      {{{0, h, 0},
        {-h * coupling.hand_stiffness / coupling.inertia, -h * damping / coupling.inertia, h / coupling.inertia},
        {0, 0, 0}}});
  return {.x_v = step[0][1], .x_f = step[0][2], .v_v = step[1][1], .v_f = step[1][2]};
}

Vec3 Handle::move(const HandleParameters& coupling, const Propagator& by, double h, const Vec3& f, Vec3& v) {
  if (v == Vec3{} && norm(f) <= coupling.coulomb) return {};
  const double loss = 0.5 * h * coupling.coulomb / coupling.inertia;
  v = slowed(v, loss);
  const Vec3 way = by.x_v * v + by.x_f * f;
  v = slowed(by.v_v * v + by.v_f * f, loss);
  return way;
}

void Handle::advance(double dt, const Wrench& wrench, const MotionState& from, const MotionState& to) {
  if (dt <= 0) return;
  const int steps = std::max(1, static_cast<int>(std::ceil(dt / sub_step_ - 1e-9)));
  const double h = dt / steps;
  if (h != h_) {
    h_ = h;
    translate_by_ = make_propagator(translation_, h);
    if (rotate_) rotate_by_ = make_propagator(rotation_, h);
  }
  for (int i = 0; i < steps; ++i) {
    const MotionState target = interpolate(from, to, dt, (i + 0.5) / steps, rotate_);
    const Vec3 force_W =
        wrench.force + translation_.hand_stiffness * (target.X.p - state_.X.p) + translation_.hand_damping * target.V.v;
    state_.X.p += move(translation_, translate_by_, h, force_W, state_.V.v);
    if (rotate_) {
      const Vec3 arc_W = to_rotation_vector(target.X.R * inverse(state_.X.R));
      const Vec3 torque_W = wrench.torque + rotation_.hand_stiffness * arc_W + rotation_.hand_damping * target.V.w;
      const Vec3 turn_W = move(rotation_, rotate_by_, h, torque_W, state_.V.w);
      state_.X.R = normalized(from_rotation_vector(turn_W) * state_.X.R);
    } else {
      state_.X.R = target.X.R;
    }
  }
}

}  // namespace tactor
