// Amplifier, friction, cogging, noise and lines of the simulated device are what their formulas say.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "devices/simulated/encoder.hpp"
#include "devices/simulated/handle.hpp"
#include "devices/simulated/line_delay.hpp"

BOOST_AUTO_TEST_SUITE(parts_test)

using namespace tactor;

namespace {

constexpr double tick = 1e-3;
constexpr double sub_step = 1e-4;
constexpr double pi = std::numbers::pi;
const HandleParameters free_body{.inertia = 0.5};

/// Simpson's rule over n (even) intervals.
template <class F>
double integral(F f, double a, double b, int n) {
  double sum = f(a) + f(b);
  for (int i = 1; i < n; ++i) sum += (i % 2 == 1 ? 4 : 2) * f(a + (b - a) * i / n);
  return sum * (b - a) / n / 3;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_force_step_comes_through_the_amplifier_as_one_minus_an_exponential) {
  const double bandwidth = 80, tau = 1 / (2 * pi * bandwidth);
  Amplifier amplifier({.bandwidth = bandwidth});
  double before = 0;
  for (int i = 1; i <= 100; ++i) {
    const double t = i * 1e-4;
    const double mean = amplifier.advance(1e-4, {{3, 0, 0}, {0, 0.2, 0}}).force.x;
    const double expected = 3 * (1 - std::exp(-t / tau));
    BOOST_TEST(std::abs(amplifier.output().force.x - expected) < 1e-13);
    BOOST_TEST(std::abs(amplifier.output().torque.y - expected / 15) < 1e-14);
    // The mean over the step is the integral of that exponential.
    BOOST_TEST(std::abs(mean - (3 - 3 * tau * (std::exp(-(t - 1e-4) / tau) - std::exp(-t / tau)) / 1e-4)) < 1e-12);
    BOOST_TEST(mean > before);
    before = expected;
  }
}

BOOST_AUTO_TEST_CASE(an_amplifier_without_a_pole_gives_what_is_commanded_at_once) {
  Amplifier amplifier({});
  const Wrench u{{1, -2, 3}, {0.1, 0.2, 0.3}};
  BOOST_TEST((amplifier.advance(1e-4, u).force == u.force));
  BOOST_TEST((amplifier.output().torque == u.torque));
  BOOST_TEST(!amplifier.saturated());
}

BOOST_AUTO_TEST_CASE(the_motors_are_limited_by_norm_and_keep_the_direction) {
  Amplifier amplifier({.force_max = 2.5, .torque_max = 0.05});
  const Wrench motors = amplifier.advance(1e-3, {{3, -4, 0}, {0, 0, 0.1}});
  BOOST_TEST(norm(motors.force - Vec3{1.5, -2, 0}) < 1e-15);
  BOOST_TEST(norm(motors.torque - Vec3{0, 0, 0.05}) < 1e-16);
  BOOST_TEST(amplifier.saturated());
  BOOST_TEST((amplifier.advance(1e-3, {{1, 2, 0}, {}}).force == Vec3{1, 2, 0}));
  BOOST_TEST(!amplifier.saturated());
}

BOOST_AUTO_TEST_CASE(a_limited_motor_comes_back_when_the_pole_has_come_down_to_the_limit) {
  // The pole is before the limit: after a command of 4 N the state has to fall from 4 N to 1 N, for tau ln 4.
  const double bandwidth = 50, tau = 1 / (2 * pi * bandwidth);
  Amplifier amplifier({.bandwidth = bandwidth, .force_max = 1});
  for (int i = 0; i < 1000; ++i) amplifier.advance(1e-4, {{4, 0, 0}, {}});
  int steps = 0;
  for (; amplifier.output().force.x > 1 - 1e-9; ++steps) amplifier.advance(1e-5, {});
  BOOST_TEST(std::abs(steps * 1e-5 - tau * std::log(4.0)) <= 1e-5);
}

BOOST_AUTO_TEST_CASE(a_body_behind_an_amplifier_moves_and_gets_energy_as_the_pole_says) {
  // M v' = F (1 - e^(-t/tau)) from rest: v = F/M (t - tau (1 - e^(-t/tau))).
  const double tau = 1 / (2 * pi * 50.0), force = 2;
  Handle handle(free_body, free_body, sub_step, false, {.amplifier = {.bandwidth = 50}});
  for (int i = 1; i <= 100; ++i) {
    handle.advance(tick, {{0, force, 0}, {}}, {}, {});
    const double t = i * tick;
    const double v = force / 0.5 * (t - tau * (1 - std::exp(-t / tau)));
    BOOST_TEST(std::abs(handle.state().V.v.y - v) < 1e-13);
  }
  const double v = handle.state().V.v.y;
  BOOST_TEST(std::abs(handle.work() - 0.5 * 0.5 * v * v) < 1e-13);
}

BOOST_AUTO_TEST_CASE(cogging_repeats_after_its_period_and_takes_no_energy_over_a_closed_path) {
  const double period = 4e-3;
  const Cogging cogging({.force = 0.07, .period = period});
  for (int i = 0; i < 50; ++i) {
    const Vec3 p{0.31e-3 * i, -0.17e-3 * i, 1e-3};
    BOOST_TEST(norm(cogging.force(p) - cogging.force(p + Vec3{period, -2 * period, 3 * period})) < 1e-14);
    BOOST_TEST(std::abs(cogging.force(p).x + 0.07 * std::sin(2 * pi * p.x / period)) < 1e-15);
    // The force is what the potential falls by.
    const double h = 1e-7;
    BOOST_TEST(std::abs((cogging.energy(p - Vec3{0, h, 0}) - cogging.energy(p + Vec3{0, h, 0})) / (2 * h) -
                        cogging.force(p).y) < 1e-8);
  }
  // Round a tilted ellipse that is no multiple of the period: the sum over a closed smooth path is exact very soon.
  double work = 0;
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * pi * i / n;
    const Vec3 p{7.3e-3 * std::cos(a), 5.1e-3 * std::sin(a), 3.7e-3 * std::cos(a + 1)};
    const Vec3 dp{-7.3e-3 * std::sin(a), 5.1e-3 * std::cos(a), -3.7e-3 * std::sin(a + 1)};
    work += dot(cogging.force(p), dp) * 2 * pi / n;
  }
  BOOST_TEST(std::abs(work) < 1e-16);
}

BOOST_AUTO_TEST_CASE(a_body_that_slides_over_cogging_keeps_its_energy) {
  const HandleParameters body{.inertia = 0.1};
  const CoggingParameters ripple{.force = 0.05, .period = 2e-3};
  const Cogging cogging(ripple);
  for (const double v0 : {0.003, 0.05}) {  // caught in one well, and over all of them
    Handle handle(body, body, sub_step, false, {.cogging = ripple});
    handle.place({{}, {{v0, 0, 0}, {}}});
    const auto energy = [&] {
      return 0.05 * dot(handle.state().V.v, handle.state().V.v) + cogging.energy(handle.state().X.p);
    };
    const double start = energy(), barrier = 2 * 0.05 * 2e-3 / (2 * pi);
    double farthest = 0;
    for (int i = 0; i < 20000; ++i) {
      handle.advance(tick, {}, {}, {});
      BOOST_REQUIRE(std::abs(energy() - start) < 1e-4 * barrier);
      farthest = std::max(farthest, std::abs(handle.state().X.p.x));
    }
    if (v0 < 0.01) {
      // The well holds it: 1/2 m v^2 = A P / (2 pi) (1 - cos(2 pi x / P)).
      const double x = std::acos(1 - 0.05 * v0 * v0 / (0.5 * barrier)) * 2e-3 / (2 * pi);
      BOOST_TEST(std::abs(farthest / x - 1) < 1e-3);
    } else {
      BOOST_TEST(farthest > 0.5);
    }
  }
}

BOOST_AUTO_TEST_CASE(small_swings_in_a_cog_have_the_frequency_of_its_stiffness) {
  const HandleParameters body{.inertia = 0.1};
  Handle handle(body, body, sub_step, false, {.cogging = {.force = 0.05, .period = 2e-3}});
  const double omega = std::sqrt(2 * pi * 0.05 / 2e-3 / 0.1);
  handle.place({{}, {{0, 1e-5, 0}, {}}});
  for (int i = 1; i <= 2000; ++i) {
    handle.advance(tick, {}, {}, {});
    BOOST_REQUIRE(std::abs(handle.state().X.p.y - 1e-5 / omega * std::sin(omega * i * tick)) < 1e-10);
  }
}

BOOST_AUTO_TEST_CASE(friction_follows_the_stribeck_curve) {
  const Friction friction({.coulomb = 0.3, .breakaway = 0.5, .stribeck_velocity = 0.01});
  BOOST_TEST(friction.holds() == 0.5);
  for (const double v : {1e-6, 0.005, 0.01, 0.03, 0.5}) {
    BOOST_TEST(std::abs(friction.level(v) - (0.3 + 0.2 * std::exp(-v * v * 1e4))) < 1e-15);
  }
  // A breakaway level below the Coulomb level does not count.
  const Friction plain({.coulomb = 0.3, .breakaway = 0.1, .stribeck_velocity = 0.01});
  BOOST_TEST(plain.holds() == 0.3);
  BOOST_TEST(plain.level(0.001) == 0.3);
}

BOOST_AUTO_TEST_CASE(a_body_breaks_away_at_the_static_level_and_slides_on_above_the_coulomb_level) {
  const HandleParameters body{.inertia = 0.5, .coulomb = 0.3, .breakaway = 0.5, .stribeck_velocity = 0.01};
  Handle handle(body, free_body, sub_step, false);
  for (int i = 0; i < 1000; ++i) handle.advance(tick, {{0.4999, 0, 0}, {}}, {}, {});
  BOOST_TEST((handle.state().X.p == Vec3{}));
  for (int i = 0; i < 1000; ++i) handle.advance(tick, {{0.51, 0, 0}, {}}, {}, {});
  BOOST_TEST(handle.state().V.v.x > 0.2);
  // What would not start it keeps it going, with (F - F_c) / M far above the Stribeck velocity.
  const double v = handle.state().V.v.x;
  for (int i = 0; i < 1000; ++i) handle.advance(tick, {{0.4, 0, 0}, {}}, {}, {});
  BOOST_TEST(std::abs(handle.state().V.v.x - (v + 0.1 / 0.5)) < 1e-9);
}

BOOST_AUTO_TEST_CASE(a_body_that_stops_under_a_force_below_its_breakaway_level_stays_where_it_is) {
  const HandleParameters body{.inertia = 0.5, .coulomb = 0.3, .breakaway = 0.4, .stribeck_velocity = 0.01};
  const HandleParameters coulomb{.inertia = 0.5, .coulomb = 0.3};
  Handle one(body, free_body, sub_step, false);
  Handle two(coulomb, free_body, sub_step, false, {.transmission = transmission_of(0.5, 0.5, 60, 0.3, 0)});
  for (Handle* handle : {&one, &two}) {
    handle->place({{}, {{0.1, 0, 0}, {}}});
    for (int i = 0; i < 2000; ++i) handle->advance(tick, {{0.25, 0, 0}, {}}, {}, {});
    const Vec3 rest = handle->motor_side().X.p;
    for (int i = 0; i < 2000; ++i) handle->advance(tick, {{0.25, 0, 0}, {}}, {}, {});
    BOOST_TEST((handle->motor_side().X.p == rest));
    BOOST_TEST(rest.x > 0.01);
  }
}

BOOST_AUTO_TEST_CASE(a_body_stops_under_stribeck_friction_where_the_integral_over_its_speed_says) {
  // M v dv = -F(v) dx: the way is the integral of M v / F(v), the time that of M / F(v).
  const double m = 0.5, v0 = 0.05;
  const HandleParameters body{.inertia = m, .coulomb = 0.2, .breakaway = 0.5, .stribeck_velocity = 0.02};
  const auto level = [](double v) { return 0.2 + 0.3 * std::exp(-v * v / 4e-4); };
  const double way = integral([&](double v) { return m * v / level(v); }, 0, v0, 2000);
  const double time = integral([&](double v) { return m / level(v); }, 0, v0, 2000);
  Handle handle(body, free_body, sub_step, false);
  handle.place({{}, {0.6 * Vec3{v0, 0, 0} + 0.8 * Vec3{0, v0, 0}, {}}});
  double stopped = 0;
  for (int i = 1; i <= 500; ++i) {
    handle.advance(sub_step * 10, {}, {}, {});
    if (stopped == 0 && handle.state().V.v == Vec3{}) stopped = i * sub_step * 10;
  }
  BOOST_TEST(std::abs(norm(handle.state().X.p) - way) < 1e-4 * way);
  BOOST_TEST(std::abs(stopped - time) <= 2e-3);
}

BOOST_AUTO_TEST_CASE(steady_sliding_takes_the_force_of_the_stribeck_curve) {
  // A hand that goes at the constant speed V bends its spring by F(V) / k_h; its damper keeps that from stick-slip.
  const HandleParameters body{.inertia = 0.3,
                              .coulomb = 0.1,
                              .hand_damping = 30,
                              .hand_stiffness = 200,
                              .breakaway = 0.2,
                              .stribeck_velocity = 0.01};
  for (const double V : {0.002, 0.007, 0.01, 0.02, 0.1}) {
    const auto target = [&](double t) { return MotionState{{{0, 0, V * t}, {}}, {{0, 0, V}, {}}}; };
    Handle handle(body, free_body, sub_step, false);
    handle.place(target(0));
    for (int i = 0; i < 5000; ++i) handle.advance(tick, {}, target(i * tick), target((i + 1) * tick));
    const double force = 200 * (target(5.0).X.p.z - handle.state().X.p.z);
    BOOST_TEST(std::abs(force - (0.1 + 0.1 * std::exp(-V * V * 1e4))) < 1e-5);
  }
}

BOOST_AUTO_TEST_CASE(encoder_noise_has_its_rms_no_mean_and_depends_on_the_seed_alone) {
  const double noise = 3e-5, noise_angle = 2e-4;
  EncoderParameters parameters{
      .velocity = {1e-5, 1e-5}, .noise = noise, .noise_angle = noise_angle, .seed = 7, .interval = 1e-3};
  Encoder encoder(parameters, true), same(parameters, true);
  parameters.seed = 8;
  Encoder other(parameters, true);
  const MotionState truth{{{0.1, -0.2, 0.3}, {}}, {}};
  const int n = 20000;
  Vec3 sum, squares, squares_angle;
  double product = 0;
  int differing = 0;
  for (int i = 0; i < n; ++i) {
    const Time now = Time::from_seconds(i * tick);
    const MotionState shown = encoder.read(truth, now);
    const MotionState again = same.read(truth, now);
    BOOST_REQUIRE((shown.X == again.X && shown.V.v == again.V.v));
    if (other.read(truth, now).X.p != shown.X.p) ++differing;
    const Vec3 e = shown.X.p - truth.X.p, r = to_rotation_vector(shown.X.R);
    sum += e;
    squares += {e.x * e.x, e.y * e.y, e.z * e.z};
    squares_angle += {r.x * r.x, r.y * r.y, r.z * r.z};
    product += e.x * e.y;
  }
  BOOST_TEST(differing == n);
  for (int axis = 0; axis < 3; ++axis) {
    // Four standard deviations of the estimates.
    BOOST_TEST(std::abs(std::sqrt(squares[axis] / n) / noise - 1) < 4 / std::sqrt(2.0 * n));
    BOOST_TEST(std::abs(std::sqrt(squares_angle[axis] / n) / noise_angle - 1) < 4 / std::sqrt(2.0 * n));
    BOOST_TEST(std::abs(sum[axis] / n) < 4 * noise / std::sqrt(1.0 * n));
  }
  BOOST_TEST(std::abs(product / n) < 4 * noise * noise / std::sqrt(1.0 * n));
}

BOOST_AUTO_TEST_CASE(noise_comes_before_rounding) {
  const double step = 1e-5;
  Encoder encoder({.step = step, .velocity = {1e-5, 1e-5}, .noise = 2e-5, .seed = 3, .interval = 1e-3}, false);
  int moved = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = encoder.read({}, Time::from_seconds(i * tick)).X.p;
    BOOST_TEST(std::abs(p.x / step - std::round(p.x / step)) < 1e-9);
    if (p.x != 0) ++moved;
  }
  BOOST_TEST(moved > 600);
}

BOOST_AUTO_TEST_CASE(a_line_gives_what_went_in_so_many_ticks_before) {
  for (const std::size_t ticks : {0U, 1U, 5U}) {
    LineDelay<int> line(ticks);
    line.fill(-1);
    for (int i = 0; i < 40; ++i) {
      const int expected = i < static_cast<int>(ticks) ? -1 : i - static_cast<int>(ticks);
      BOOST_TEST(line.pass(i) == expected);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_delay_is_the_nearest_whole_number_of_ticks) {
  BOOST_TEST(delay_in_ticks(0, 1000) == 0U);
  BOOST_TEST(delay_in_ticks(0.00049, 1000) == 0U);
  BOOST_TEST(delay_in_ticks(0.0005, 1000) == 1U);
  BOOST_TEST(delay_in_ticks(0.0014, 1000) == 1U);
  BOOST_TEST(delay_in_ticks(0.0016, 1000) == 2U);
  BOOST_TEST(delay_in_ticks(0.0016, 10000) == 16U);
}

BOOST_AUTO_TEST_SUITE_END()
