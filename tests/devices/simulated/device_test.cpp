// The simulated device shows its handle through encoders, commands clamped forces, and closes the loop through the
// hand.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "devices/simulated/simulated.hpp"
#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "tests/devices/simulated/bench.hpp"

BOOST_AUTO_TEST_SUITE(device_test)

using namespace tactor;
using test::Bench;
using test::open_gate;
using test::with;

namespace {

MotionState swinging(double t) {
  return {
      {{0.05 * std::sin(3 * t), 0.02 * std::cos(7 * t), 0.1 * t}, from_rotation_vector({0, 0, 0.5 * std::sin(2 * t)})},
      {{0.15 * std::cos(3 * t), -0.14 * std::sin(7 * t), 0.1}, {0, 0, std::cos(2 * t)}}};
}

constexpr double mass = 0.65, damping = 6.5, stiffness = 135;  // of the defaults, without friction of the handle
const std::map<std::string, ParamValue> smooth_loop =
    with({{"loop", std::string("closed")}, {"damping", 0.0}, {"friction", 0.0}, {"encoder_step", 0.0}}, open_gate);

}  // namespace

BOOST_AUTO_TEST_CASE(an_open_loop_handle_is_where_the_target_says_to_half_an_encoder_step) {
  const double step = 1e-4, step_angle = 1e-3;
  Bench bench({{"encoder_step", step}, {"encoder_step_angle", step_angle}});
  for (int i = 0; i < 1000; ++i) {
    const MotionState wanted = swinging(bench.now().seconds());
    bench.target(wanted);
    bench.tick();
    BOOST_REQUIRE(bench.shown.has_value());
    BOOST_TEST((bench.truth.X_WD == wanted.X));
    for (int axis = 0; axis < 3; ++axis) {
      BOOST_TEST(std::abs(bench.shown->X_WD.p[axis] - wanted.X.p[axis]) <= step / 2 + 1e-15);
      const double steps = bench.shown->X_WD.p[axis] / step;
      BOOST_TEST(std::abs(steps - std::round(steps)) < 1e-9);
    }
    BOOST_TEST(std::abs(to_rotation_vector(bench.shown->X_WD.R).z - to_rotation_vector(wanted.X.R).z) <=
               step_angle / 2 + 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(the_velocity_of_an_encoder_is_estimated_from_its_steps_and_true_without_them) {
  const double step = 1e-5;
  Bench coarse({{"encoder_step", step}});
  Bench exact({{"encoder_step", 0.0}, {"encoder_step_angle", 0.0}});
  PoseFilter filter({}, step / std::sqrt(12.0), 1e-4 / std::sqrt(12.0), 1e-3, true);
  for (int i = 0; i < 500; ++i) {
    const double t = coarse.now().seconds();
    const MotionState ramp{{{0.0873 * t, 0, 0}, {}}, {{0.0873, 0, 0}, {0, 0, 0.1}}};
    coarse.target(ramp);
    coarse.tick();
    exact.target(ramp);
    exact.tick();
    if (i == 0) BOOST_TEST(coarse.shown->V_WD.v.x == 0.0);
    filter.take({{step * std::round(0.0873 * t / step), 0, 0}, {}}, Time::from_seconds(t));
    BOOST_TEST(std::abs(coarse.shown->V_WD.v.x - filter.velocity().v.x) < 1e-12);
    // A filter that is ready for a trembling hand takes some of the steps for motion.
    if (t > 0.1) BOOST_TEST(std::abs(coarse.shown->V_WD.v.x - 0.0873) < 0.005);
    BOOST_TEST(exact.shown->V_WD.v.x == 0.0873);
    BOOST_TEST(exact.shown->V_WD.w.z == 0.1);
  }
}

BOOST_AUTO_TEST_CASE(nothing_is_shown_before_the_first_target_and_zero_commanded_before_the_first_segment) {
  Bench bench({});
  bench.tick();
  BOOST_TEST(!bench.shown.has_value());
  BOOST_TEST((bench.commanded.force == Vec3{}));
  bench.target({});
  bench.tick();
  BOOST_TEST(bench.shown.has_value());
  BOOST_TEST((bench.commanded.force == Vec3{}));
}

BOOST_AUTO_TEST_CASE(segments_are_evaluated_at_the_tick_and_clamped_along_their_direction) {
  Bench bench(with({{"force_max", 5.0}, {"torque_max", 0.1}}, open_gate));
  bench.target({});
  ForceSegment s;
  s.begin = Time{0};
  s.end = Time{10'000'000};
  s.c = {Wrench{{1, 0, 0}, {}}, Wrench{{2, 0, 0}, {0, 0, 0.05}}, Wrench{{3, 0, 0}, {}}, Wrench{{-4, 0, 0}, {}}};
  bench.segment(s);
  bench.tick();
  BOOST_TEST((bench.commanded.force == Vec3{}));
  for (int i = 1; i < 20; ++i) {
    bench.tick();
    const double u = std::min(i / 10.0, 1.0);
    BOOST_TEST(std::abs(bench.commanded.force.x - (1 + 2 * u + 3 * u * u - 4 * u * u * u)) < 1e-12);
    BOOST_TEST(std::abs(bench.commanded.torque.z - 0.05 * u) < 1e-15);
  }
  bench.segment(constant_segment(bench.now(), {{30, -40, 0}, {0, 0, -7}}));
  bench.tick();
  BOOST_TEST(norm(bench.commanded.force - Vec3{3, -4, 0}) < 1e-14);
  BOOST_TEST(norm(bench.commanded.torque - Vec3{0, 0, -0.1}) < 1e-15);
}

BOOST_AUTO_TEST_CASE(by_default_a_force_comes_in_over_a_tenth_of_a_second_and_outlives_its_segment_by_two) {
  Bench bench({});
  bench.target({});
  for (int i = 0; i <= 400; ++i) {
    // Segments until the 200th tick.
    if (i <= 200) bench.segment(constant_segment(bench.now(), {{0, 2, 0}, {}}));
    bench.tick();
    const double x = i <= 200 ? i / 100.0 : std::max(4 - i / 100.0, 0.0);
    const double gain = x >= 1 ? 1 : x * x * (3 - 2 * x);
    BOOST_TEST(std::abs(bench.commanded.force.y - 2 * gain) < 1e-13);
  }
  BOOST_TEST((bench.commanded.force == Vec3{}));
}

BOOST_AUTO_TEST_CASE(a_target_that_is_not_finite_stops_the_force) {
  Bench bench(open_gate);
  bench.target({});
  bench.segment(constant_segment(bench.now(), {{1, 0, 0}, {}}));
  bench.tick();
  bench.tick();
  BOOST_TEST(bench.commanded.force.x == 1.0);
  MotionState nowhere;
  nowhere.X.p.x = std::numeric_limits<double>::quiet_NaN();
  bench.target(nowhere);
  bench.tick();
  BOOST_TEST(!bench.shown.has_value());
  BOOST_TEST((bench.commanded.force == Vec3{}));
  // Neither position nor velocity remembers it.
  bench.target({});
  bench.tick();
  BOOST_REQUIRE(bench.shown.has_value());
  BOOST_TEST((bench.shown->X_WD.p == Vec3{}));
  BOOST_TEST((bench.shown->V_WD.v == Vec3{}));
}

BOOST_AUTO_TEST_CASE(the_closed_loop_moves_under_the_commanded_force_and_reports_its_energy) {
  Bench bench(smooth_loop);
  const double force = 2, rest = force / stiffness;
  const double decay = 0.5 * damping / mass, omega = std::sqrt(stiffness / mass - decay * decay);
  double fastest = 0;
  for (int i = 0; i < 1500; ++i) {
    bench.target({});
    if (i == 0) bench.segment(constant_segment(bench.now(), {{force, 0, 0}, {}}));
    // The step response from rest; the gate lets the force through at the second tick, which is at 1 ms.
    const double t = std::max(bench.now().seconds() - 0.001, 0.0);
    bench.tick();
    const double expected =
        rest * (1 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    BOOST_TEST(std::abs(bench.truth.X_WD.p.x - expected) < 1e-13);
    fastest = std::max(fastest, bench.truth.V_WD.v.x);
  }
  // The most work a held force has done: force times the way to the top of the overshoot.
  const double overshoot = std::exp(-decay / omega * 3.141592653589793);
  BOOST_TEST(std::abs(bench.metrics().at("device.energy_generated_J") - force * rest * (1 + overshoot)) < 1e-6);
  BOOST_TEST(bench.metrics().at("device.max_speed_m_per_s") == fastest);
}

BOOST_AUTO_TEST_CASE(a_force_against_the_motion_generates_no_energy) {
  Bench bench(smooth_loop);
  for (int i = 0; i < 1500; ++i) {
    const double t = bench.now().seconds();
    // A damper on the handle, seen a tick late, while the hand moves one way and then stays.
    const double s = std::min(t, 1.0);
    bench.target({{{0.1 * s, 0, 0}, {}}, {{t < 1 ? 0.1 : 0, 0, 0}, {}}});
    bench.tick();
    bench.segment(constant_segment(bench.now(), {-2.0 * bench.truth.V_WD.v, {}}));
  }
  BOOST_TEST(bench.metrics().at("device.energy_generated_J") < 1e-5);
}

BOOST_AUTO_TEST_CASE(a_reference_run_follows_the_path_of_the_judged_run) {
  Bench judged(smooth_loop);
  BOOST_TEST(judged.device().must_be_followed());
  std::vector<DeviceState> path;
  for (int i = 0; i < 1000; ++i) {
    judged.target(swinging(judged.now().seconds()));
    judged.segment(constant_segment(judged.now(), {{std::sin(0.05 * i), 1, 0}, {0, 0, 0.02}}));
    judged.tick();
    path.push_back(judged.truth);
  }
  std::map<std::string, ParamValue> given = smooth_loop;
  given["rate"] = 10000.0;
  given["encoder_step_angle"] = 0.0;
  Bench reference(given);
  reference.device().follow(judged.device());
  for (std::size_t i = 0; i < 10'000; ++i) {
    reference.target({});
    reference.tick();
    if (i % 10 == 0) {
      BOOST_REQUIRE(norm(reference.shown->X_WD.p - path[i / 10].X_WD.p) < 1e-15);
      BOOST_REQUIRE(norm(to_rotation_vector(reference.shown->X_WD.R * inverse(path[i / 10].X_WD.R))) < 1e-14);
      BOOST_REQUIRE(norm(reference.shown->V_WD.v - path[i / 10].V_WD.v) < 1e-9);
    } else if (i / 10 + 1 < path.size()) {
      // Between its samples the path is smooth: less than a micrometre from the chord here.
      const double s = static_cast<double>(i % 10) / 10;
      const Vec3 chord = (1 - s) * path[i / 10].X_WD.p + s * path[i / 10 + 1].X_WD.p;
      BOOST_REQUIRE(norm(reference.shown->X_WD.p - chord) < 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_path_longer_than_the_run_is_not_kept_and_no_tick_allocates) {
  Bench bench(smooth_loop);  // for a run of 2 s
  std::int64_t most = 0;
  for (int i = 0; i < 3000; ++i) {
    bench.target(swinging(bench.now().seconds()));
    bench.segment(constant_segment(bench.now(), {{std::sin(0.05 * i), 1, 0}, {0, 0, 0.02}}));
    const std::int64_t before = thread_heap_calls();
    bench.tick();
    most = std::max(most, thread_heap_calls() - before);
  }
  BOOST_TEST(most == 0);
  BOOST_TEST((thread_heap_calls() > 0) == heap_calls_are_counted());
  BOOST_TEST(bench.metrics().at("device.unkept_path_samples") == 3000.0 - 2002.0);
}

BOOST_AUTO_TEST_CASE(an_open_loop_needs_no_following) {
  Bench bench({});
  BOOST_TEST(!bench.device().must_be_followed());
  BOOST_TEST(bench.metrics().count("device.energy_generated_J") == 0U);
}

BOOST_AUTO_TEST_CASE(motors_let_go_of_a_command_after_two_ticks_and_of_what_is_on_the_line) {
  // A free handle: its speed tells for how long the motors pushed.
  const std::map<std::string, ParamValue> free =
      with({{"hand_damping", 0.0}, {"hand_stiffness", 0.0}, {"hand_mass", 0.0}, {"mass", 0.5}}, smooth_loop);
  for (const int missed : {1, 2, 20}) {
    Bench bench(free, false);
    bench.target({});
    bench.segment(constant_segment(bench.now(), {{2, 0, 0}, {}}));
    for (int i = 0; i < 20; ++i) bench.tick();
    const double before = bench.truth.V_WD.v.x;
    bench.miss(missed);
    bench.tick();
    constexpr double pushed = 2e-3;  // s, whether the next tick came after 2, 3 or 21 ms
    BOOST_TEST(std::abs(bench.truth.V_WD.v.x - before - 2 / 0.5 * pushed) < 1e-9);
    BOOST_TEST(bench.metrics().count("device.causes.expired") == (missed > 1 ? 1U : 0U));
  }
  Bench late(with({{"delay_out", 0.003}}, free), false);
  late.target({});
  late.segment(constant_segment(late.now(), {{2, 0, 0}, {}}));
  for (int i = 0; i < 20; ++i) late.tick();
  late.miss(20);
  late.tick();
  const double after = late.truth.V_WD.v.x;
  for (int i = 0; i < 3; ++i) late.tick();
  BOOST_TEST(std::abs(late.truth.V_WD.v.x - after) < 1e-12);
  late.tick();
  BOOST_TEST(late.truth.V_WD.v.x > after);
}

BOOST_AUTO_TEST_SUITE_END()
