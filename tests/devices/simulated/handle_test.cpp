// The handle in a hand follows the closed-form solutions of its equation of motion.
#include "devices/simulated/handle.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>

BOOST_AUTO_TEST_SUITE(handle_test)

using namespace tactor;

namespace {

/// Usual hand on a light handle: M = 0.65 kg, 6.7 N s/m, 135 N/m in all.
const HandleParameters hand{.inertia = 0.65, .damping = 0.2, .coulomb = 0, .hand_damping = 6.5, .hand_stiffness = 135};
const HandleParameters free_body{.inertia = 0.5};
constexpr double sub_step = 1e-4;
constexpr double tick = 1e-3;

/// The free response from (x0, v0) of an underdamped second-order system.
struct Oscillation {
  Oscillation(const HandleParameters& coupling, double x, double v)
      : decay(0.5 * (coupling.damping + coupling.hand_damping) / coupling.inertia),
        omega(std::sqrt(coupling.hand_stiffness / coupling.inertia - decay * decay)),
        x0(x),
        v0(v) {}
  [[nodiscard]] double x(double t) const {
    return std::exp(-decay * t) * (x0 * std::cos(omega * t) + (v0 + decay * x0) / omega * std::sin(omega * t));
  }
  double decay, omega, x0, v0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_free_response_is_the_analytic_one) {
  Handle handle(hand, free_body, sub_step, false);
  handle.place({{{0.02, 0, -0.01}, {}}, {{0.1, 0, 0}, {}}});
  const Oscillation x(hand, 0.02, 0.1);
  const Oscillation z(hand, -0.01, 0);
  for (int i = 1; i <= 1000; ++i) {
    handle.advance(tick, {}, {}, {});
    BOOST_TEST(std::abs(handle.state().X.p.x - x.x(i * tick)) < 1e-14);
    BOOST_TEST(std::abs(handle.state().X.p.z - z.x(i * tick)) < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(a_held_force_gives_the_analytic_step_response) {
  Handle handle(hand, free_body, sub_step, false);
  const double rest = 2.0 / hand.hand_stiffness;
  const Oscillation away(hand, -rest, 0);
  for (int i = 1; i <= 1000; ++i) {
    handle.advance(tick, {{0, 2, 0}, {}}, {}, {});
    BOOST_TEST(std::abs(handle.state().X.p.y - (rest + away.x(i * tick))) < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(a_rotation_about_one_axis_is_the_analytic_one) {
  const HandleParameters wrist{.inertia = 5.5e-4, .damping = 1e-4, .hand_damping = 0.01, .hand_stiffness = 0.5};
  Handle handle(hand, wrist, sub_step, true);
  const Vec3 axis = Vec3{1, 2, -2} / 3.0;
  handle.place({{{}, from_rotation_vector(0.8 * axis)}, {}});
  const Oscillation angle(wrist, 0.8, 0);
  for (int i = 1; i <= 300; ++i) {
    handle.advance(tick, {}, {}, {});
    BOOST_TEST(norm(to_rotation_vector(handle.state().X.R) - angle.x(i * tick) * axis) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(a_moving_target_drags_the_handle_as_the_transfer_function_says) {
  // x / x_T = (b_h s + k_h) / (M s^2 + (b + b_h) s + k_h) at s = i w, once the start has died away.
  const double w = 2 * 3.141592653589793 * 3;
  const double amplitude = 0.03;
  const auto target = [&](double t) {
    return MotionState{{{amplitude * std::sin(w * t), 0, 0}, {}}, {{amplitude * w * std::cos(w * t), 0, 0}, {}}};
  };
  Handle handle(hand, free_body, sub_step, false);
  handle.place(target(0));
  const double re_top = hand.hand_stiffness, im_top = hand.hand_damping * w;
  const double re_bottom = hand.hand_stiffness - hand.inertia * w * w,
               im_bottom = (hand.damping + hand.hand_damping) * w;
  const double gain = std::hypot(re_top, im_top) / std::hypot(re_bottom, im_bottom);
  const double phase = std::atan2(im_top, re_top) - std::atan2(im_bottom, re_bottom);
  for (int i = 0; i < 8000; ++i) {
    const double t = i * tick;
    handle.advance(tick, {}, target(t), target(t + tick));
    const double expected = gain * amplitude * std::sin(w * (t + tick) + phase);
    if (i > 6000) BOOST_TEST(std::abs(handle.state().X.p.x - expected) < 1e-7);
  }
}

BOOST_AUTO_TEST_CASE(coulomb_friction_brings_a_body_to_rest_at_the_analytic_distance) {
  // M v0^2 / (2 c), in the direction of the velocity.
  const HandleParameters coupling{.inertia = 0.5, .coulomb = 0.4};
  Handle handle(coupling, free_body, sub_step, false);
  const Vec3 v0{0.3, -0.4, 0};
  handle.place({{}, {v0, {}}});
  for (int i = 0; i < 1000; ++i) handle.advance(tick, {}, {}, {});
  BOOST_TEST((handle.state().V.v == Vec3{}));
  const Vec3 expected = (0.5 * 0.25 / (2 * 0.4) / 0.5) * v0;
  BOOST_TEST(norm(handle.state().X.p - expected) < 1e-8);
}

BOOST_AUTO_TEST_CASE(coulomb_and_viscous_friction_together_stop_at_the_analytic_distance) {
  // M v' = -c - b v: distance M v0 / b - (M c / b^2) ln(1 + b v0 / c).
  const double m = 0.5, c = 0.4, b = 2, v0 = 0.6;
  const HandleParameters coupling{.inertia = m, .damping = b, .coulomb = c};
  Handle handle(coupling, free_body, sub_step, false);
  handle.place({{}, {{v0, 0, 0}, {}}});
  for (int i = 0; i < 1000; ++i) handle.advance(tick, {}, {}, {});
  BOOST_TEST((handle.state().V.v == Vec3{}));
  BOOST_TEST(std::abs(handle.state().X.p.x - (m * v0 / b - m * c / (b * b) * std::log(1 + b * v0 / c))) < 1e-7);
}

BOOST_AUTO_TEST_CASE(a_body_at_rest_stays_until_the_force_exceeds_the_friction) {
  const HandleParameters coupling{.inertia = 0.5, .coulomb = 0.4};
  Handle handle(coupling, free_body, sub_step, false);
  for (int i = 0; i < 1000; ++i) handle.advance(tick, {{0.39, 0, 0}, {}}, {}, {});
  BOOST_TEST((handle.state().X.p == Vec3{}));
  for (int i = 0; i < 1000; ++i) handle.advance(tick, {{0.5, 0, 0}, {}}, {}, {});
  // (F - c) / M for one second.
  BOOST_TEST(std::abs(handle.state().V.v.x - 0.2) < 1e-4);
  BOOST_TEST(std::abs(handle.state().X.p.x - 0.1) < 1e-4);
}

BOOST_AUTO_TEST_CASE(extreme_constants_do_not_make_it_blow_up) {
  const HandleParameters stiff{
      .inertia = 1e-3, .damping = 100, .coulomb = 1, .hand_damping = 1000, .hand_stiffness = 1e6};
  Handle handle(stiff, stiff, 1e-2, true);
  handle.place({{{0.1, 0, 0}, from_rotation_vector({0, 3, 0})}, {}});
  for (int i = 0; i < 1000; ++i) handle.advance(1e-2, {}, {}, {});
  BOOST_TEST(norm(handle.state().X.p) < 1e-5);
  BOOST_TEST(norm(to_rotation_vector(handle.state().X.R)) < 1e-5);
}

BOOST_AUTO_TEST_CASE(interpolation_meets_both_ends_with_their_velocities) {
  const MotionState a{{{0, 1, 2}, from_rotation_vector({0.1, 0, 0})}, {{1, 0, -1}, {0, 0.2, 0}}};
  const MotionState b{{{0.001, 1, 2}, from_rotation_vector({0.1, 0.0003, 0})}, {{0.5, 0.1, 0}, {0, 0.4, 0}}};
  const double dt = 1e-3;
  const MotionState at_a = interpolate(a, b, dt, 0, true);
  const MotionState at_b = interpolate(a, b, dt, 1, true);
  BOOST_TEST(norm(at_a.X.p - a.X.p) < 1e-15);
  BOOST_TEST(norm(at_a.V.v - a.V.v) < 1e-12);
  BOOST_TEST(norm(at_b.X.p - b.X.p) < 1e-15);
  BOOST_TEST(norm(at_b.V.v - b.V.v) < 1e-12);
  BOOST_TEST(norm(at_b.V.w - b.V.w) < 1e-12);
  BOOST_TEST(norm(to_rotation_vector(at_b.X.R * inverse(b.X.R))) < 1e-15);
  const double h = 1e-4;
  for (double s = 0.1; s < 1; s += 0.2) {
    const MotionState before = interpolate(a, b, dt, s - h, true);
    const MotionState after = interpolate(a, b, dt, s + h, true);
    const MotionState at = interpolate(a, b, dt, s, true);
    BOOST_TEST(norm((after.X.p - before.X.p) / (2 * h * dt) - at.V.v) < 1e-6);
    BOOST_TEST(norm(to_rotation_vector(after.X.R * inverse(before.X.R)) / (2 * h * dt) - at.V.w) < 1e-3);
  }
}

BOOST_AUTO_TEST_SUITE_END()
