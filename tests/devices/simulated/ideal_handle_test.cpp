// With every part off the handle moves as one ideal body does, to the bit.
#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "devices/simulated/handle.hpp"

BOOST_AUTO_TEST_SUITE(ideal_handle_test)

using namespace tactor;

namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

Matrix times(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 3; ++j) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

/// The ideal body's own formulas, written out for one handle of translation and rotation: M a = f - B v - K x exactly
/// over a step, and Coulomb friction as an impulse of half a step before and after it.
struct IdealBody {
  double inertia, damping, coulomb, hand_damping, hand_stiffness;

  [[nodiscard]] Matrix step(double h) const {
    Matrix a{
        {{0, h, 0}, {-h * hand_stiffness / inertia, -h * (damping + hand_damping) / inertia, h / inertia}, {0, 0, 0}}};
    double size = 0;
    for (const auto& row : a) size = std::max(size, std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]));
    int halvings = 0;
    for (; size > 0.25; size *= 0.5) ++halvings;
    for (auto& row : a) {
      for (double& entry : row) entry = std::ldexp(entry, -halvings);
    }
    const Matrix one{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Matrix sum = one;
    for (int n = 14; n >= 1; --n) {
      sum = times(a, sum);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) sum[i][j] = sum[i][j] / n + one[i][j];
      }
    }
    for (; halvings > 0; --halvings) sum = times(sum, sum);
    return sum;
  }
  [[nodiscard]] static Vec3 slowed(const Vec3& v, double loss) {
    const double speed = norm(v);
    return speed <= loss ? Vec3{} : (1.0 - loss / speed) * v;
  }
  Vec3 move(double h, const Vec3& f, Vec3& v) const {
    if (v == Vec3{} && norm(f) <= coulomb) return {};
    const Matrix by = step(h);
    const double loss = 0.5 * h * coulomb / inertia;
    v = slowed(v, loss);
    const Vec3 way = by[0][1] * v + by[0][2] * f;
    v = slowed(by[1][1] * v + by[1][2] * f, loss);
    return way;
  }
};

MotionState swinging(double t) {
  return {{{0.05 * std::sin(3 * t), 0.02 * std::cos(7 * t), 0.1 * std::sin(t)},
           from_rotation_vector({0, 0.1 * std::sin(5 * t), 0.5 * std::sin(2 * t)})},
          {{0.15 * std::cos(3 * t), -0.14 * std::sin(7 * t), 0.1 * std::cos(t)},
           {0, 0.5 * std::cos(5 * t), std::cos(2 * t)}}};
}

}  // namespace

BOOST_AUTO_TEST_CASE(with_every_part_off_the_handle_moves_as_the_ideal_body_to_the_bit) {
  const IdealBody translation{0.65, 0.2, 0.05, 6.5, 135};
  const IdealBody rotation{5.5e-4, 1e-4, 1e-3, 0.01, 0.5};
  Handle handle({.inertia = 0.65, .damping = 0.2, .coulomb = 0.05, .hand_damping = 6.5, .hand_stiffness = 135},
                {.inertia = 5.5e-4, .damping = 1e-4, .coulomb = 1e-3, .hand_damping = 0.01, .hand_stiffness = 0.5},
                1e-4, true);
  MotionState ideal = swinging(0);
  handle.place(ideal);
  const double dt = 1e-3;
  const int steps = 10;
  const double h = dt / steps;
  for (int i = 0; i < 3000; ++i) {
    // It moves, and then the target stands until it sticks.
    const double t = i < 1500 ? i * dt : 1.5;
    const double t_next = i < 1500 ? (i + 1) * dt : 1.5;
    MotionState from = swinging(t), to = swinging(t_next);
    if (i >= 1500) from.V = to.V = {};
    const Wrench u{{2 * std::sin(0.05 * i), i % 3 * 0.1, 0}, {0, 0, i < 2000 ? 0.02 * std::sin(0.1 * i) : 0}};
    const Wrench held = i < 2200 ? u : Wrench{};
    handle.advance(dt, held, from, to);
    for (int j = 0; j < steps; ++j) {
      const MotionState target = interpolate(from, to, dt, (j + 0.5) / steps, true);
      const Vec3 force_W = held.force + 135.0 * (target.X.p - ideal.X.p) + 6.5 * target.V.v;
      ideal.X.p += translation.move(h, force_W, ideal.V.v);
      const Vec3 arc_W = to_rotation_vector(target.X.R * inverse(ideal.X.R));
      const Vec3 torque_W = held.torque + 0.5 * arc_W + 0.01 * target.V.w;
      const Vec3 turn_W = rotation.move(h, torque_W, ideal.V.w);
      ideal.X.R = normalized(from_rotation_vector(turn_W) * ideal.X.R);
    }
    BOOST_REQUIRE((handle.state().X == ideal.X));
    BOOST_REQUIRE((handle.state().V.v == ideal.V.v && handle.state().V.w == ideal.V.w));
    BOOST_REQUIRE((handle.motor_side().X == ideal.X));
  }
  BOOST_TEST(norm(ideal.V.v) < 1e-5);
}

BOOST_AUTO_TEST_SUITE_END()
