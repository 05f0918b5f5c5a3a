// What crosses a line: axes with their roles, orientations that turn on and on, limits of both sides, commands that
// expire.
#include "devices/hardware/line_cycle.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(line_cycle_test)

using namespace tactor;

namespace {

constexpr std::int64_t ms = 1'000'000;

/// A handle with a pose whose third axis of rotation has no motor, and a gripper.
AxisLimits seven_axes() {
  AxisLimits limits;
  limits.axes = 7;
  limits.pose = true;
  limits.role[5] = AxisRole::sensed;
  limits.role[6] = AxisRole::gripper;
  limits.effort_max = {8, 8, 8, 0.2, 0.2, 0, 5};
  limits.speed_max = {2, 2, 2, 30, 30, 30, 2};
  limits.jump_tolerance = {1e-3, 1e-3, 1e-3, 0.05, 0.05, 0.05, 1e-3};
  return limits;
}

/// Three axes of a machine; the last has no motor.
AxisLimits three_axes() {
  AxisLimits limits;
  limits.axes = 3;
  limits.role[2] = AxisRole::sensed;
  limits.effort_max = {10, 4, 0};
  limits.speed_max = {2, 2, 2};
  return limits;
}

LineEnergyOptions energy_of(const AxisLimits& limits) {
  LineEnergyOptions options;
  options.axes = limits.axes;
  options.held = options.period * 2;
  return options;
}

/// A line on which the test makes the time.
struct Line {
  explicit Line(const AxisLimits& limits, const CommandTiming& timing = {})
      : cycle("rig", limits, timing, energy_of(limits)) {}
  bool open(const LinkLimits& theirs = {}) {
    LinkFailure failure;
    const bool good = cycle.opened(theirs, failure);
    why = failure.text;
    now = MonotonicClock::now();
    cycle.newest(report);
    return good;
  }
  const LinkReport& show(const LinkSample& sample) {
    now = now + Duration{ms};
    cycle.took(now, sample, {});
    cycle.newest(report);
    return report;
  }
  /// The loop commands, and the line has a cycle `later` ns after that.
  AxisValues pass(const AxisValues& effort, std::int64_t later = 0) {
    cycle.command(now, {effort, {}, Duration{4 * ms}});
    return after(later);
  }
  AxisValues after(std::int64_t later) {
    now = now + Duration{later};
    const AxisValues given = cycle.due(now).effort;
    cycle.newest(report);
    return given;
  }

  LineCycle cycle;
  Instant now = MonotonicClock::now();
  LinkReport report;
  std::string why;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_handle_that_turns_three_times_round_has_no_jump_and_its_angle_goes_on) {
  const Vec3 about = Vec3{2, -1, 2} / 3;
  Line line(seven_axes());
  BOOST_TEST(line.open());
  constexpr double turns = 3;
  constexpr int samples = 3000;
  LinkSample sample;
  for (int i = 0; i <= samples; ++i) {
    const double angle = 2 * std::numbers::pi * turns * i / samples;
    sample.R_BD = from_rotation_vector(angle * about);
    // A library may give either of the two quaternions of one orientation.
    if (i % 7 == 3) sample.R_BD = {-sample.R_BD.w, -sample.R_BD.x, -sample.R_BD.y, -sample.R_BD.z};
    const LinkReport& report = line.show(sample);
    BOOST_TEST_REQUIRE((report.verdict == Plausibility::Verdict::good));
    for (std::size_t a = 0; a < 3; ++a) {
      const double expected = angle * (a == 0 ? about.x : a == 1 ? about.y : about.z);
      BOOST_TEST(std::abs(report.sample.q[3 + a] - expected) < 1e-9);
    }
  }
  BOOST_TEST(line.cycle.metrics().jumps.value() == 0);
}

BOOST_AUTO_TEST_CASE(an_orientation_jumps_by_the_angle_between_two_samples_and_comes_back) {
  Line line(seven_axes());
  BOOST_TEST(line.open());
  LinkSample sample;
  line.show(sample);
  sample.R_BD = from_rotation_vector({0, 0.2, 0});  // 30 rad/s in 1 ms and the tolerance: 0.08 rad
  BOOST_TEST((line.show(sample).verdict == Plausibility::Verdict::jumped));
  BOOST_TEST(line.report.finding.axis == 3);
  BOOST_TEST(std::abs(line.report.finding.to - 0.2) < 1e-12);
  sample.R_BD = from_rotation_vector({0, 0.05, 0});
  BOOST_TEST((line.show(sample).verdict == Plausibility::Verdict::good));
  BOOST_TEST(std::abs(line.report.sample.q[4] - 0.05) < 1e-12);
  sample.R_BD = {0, 0, 0, 0};
  BOOST_TEST((line.show(sample).verdict == Plausibility::Verdict::jumped));
  BOOST_TEST(line.cycle.metrics().jumps.value() == 2);
}

BOOST_AUTO_TEST_CASE(an_axis_without_a_motor_gets_zero_and_leaves_the_others_as_they_are) {
  Line line(seven_axes());
  BOOST_TEST(line.open());
  line.pass({});
  const AxisValues wanted{1.1, -2.3, 0.7, 0.05, -0.13, 9.9, 1.7};
  const AxisValues given = line.pass(wanted);
  for (std::size_t a = 0; a < max_axes; ++a) BOOST_TEST(given[a] == (a == 5 ? 0.0 : wanted[a]));
  BOOST_TEST(line.cycle.metrics().limited.value() == 0);
  Line axes(three_axes());
  BOOST_TEST(axes.open());
  axes.pass({});
  BOOST_TEST(axes.pass({3.3, -1.7, 5.5}) == (AxisValues{3.3, -1.7, 0}));
  // A device of axes is shortened by its weakest axis, so that the direction stays.
  BOOST_TEST(axes.pass({4, -8, 5.5}) == (AxisValues{2, -4, 0}));
  BOOST_TEST(axes.cycle.metrics().limited.value() == 1);
  BOOST_TEST(axes.pass({4, std::nan(""), 5.5}) == AxisValues{});
}

BOOST_AUTO_TEST_CASE(a_wrench_is_limited_by_its_norms_and_the_gripper_by_itself) {
  Line line(seven_axes());
  BOOST_TEST(line.open());
  line.pass({});
  const AxisValues given = line.pass({6, 0, -8, 0.03, 0.04, 0, -7});
  BOOST_TEST(std::abs(std::hypot(given[0], given[1], given[2]) - 8) < 1e-12);
  BOOST_TEST(std::abs(given[0] / given[2] + 0.75) < 1e-12);
  BOOST_TEST(std::abs(given[3] / 0.03 - given[0] / 6) < 1e-12);
  BOOST_TEST(given[6] == -5.0);
}

BOOST_AUTO_TEST_CASE(the_tighter_of_the_two_limits_holds_from_the_opening_on) {
  AxisLimits ours = seven_axes();
  ours.q_min[0] = -0.1;
  Line line(ours);
  LinkLimits theirs;
  theirs.effort_max = every_axis(3);
  theirs.q_min = {-0.2, -0.05, -0.05};
  theirs.q_max = {0.2, 0.05, 0.05};
  BOOST_TEST(line.open(theirs));
  line.pass({});
  BOOST_TEST(line.pass({0, 6, 0, 0.1, 0, 0, 4}) == (AxisValues{0, 3, 0, 0.05, 0, 0, 3}));
  BOOST_TEST(line.report.limits.contains({-0.09, 0, 0, 7, 7, 7, 1}));
  BOOST_TEST(!line.report.limits.contains({-0.11, 0, 0}));
  BOOST_TEST(!line.report.limits.contains({0, 0.06, 0}));
  // A device that says less of itself when it is opened anew is held to ours again.
  BOOST_TEST(line.open({}));
  BOOST_TEST(line.report.limits.contains({-0.09, 0.06, 0}));
  theirs.q_max[0] = -0.15;
  BOOST_TEST(!line.open(theirs));
  BOOST_TEST(line.why.find("axis 1 of the device moves from -0.2") != std::string::npos, line.why);
}

BOOST_AUTO_TEST_CASE(axes_that_cannot_be_are_refused) {
  const auto refused = [](const std::function<void(AxisLimits&)>& spoil, const std::string& part) {
    AxisLimits limits = seven_axes();
    spoil(limits);
    BOOST_CHECK_EXCEPTION(
        LineCycle("rig", limits, {}, energy_of(seven_axes())), InputError,
        [&](const InputError& error) { return std::string(error.what()).find(part) != std::string::npos; });
  };
  refused([](AxisLimits& limits) { limits.axes = 9; }, "expected 1 to 8, found 9");
  refused([](AxisLimits& limits) { limits.axes = 0; }, "expected 1 to 8, found 0");
  refused([](AxisLimits& limits) { limits.role[2] = AxisRole::gripper; }, "a gripper as the last one, found 3");
  refused(
      [](AxisLimits& limits) {
        limits.axes = 6;
        limits.role[5] = AxisRole::gripper;
      },
      "3 or 6 of a pose, found 5");
  refused([](AxisLimits& limits) { limits.effort_max[1] = std::numeric_limits<double>::infinity(); },
          "a finite largest effort and speed of axis 2");
}

BOOST_AUTO_TEST_CASE(a_command_expires_and_the_next_one_comes_back_over_the_time_of_the_slew_limit) {
  const CommandTiming timing{.age_max = Duration{50 * ms}, .expires_after = Duration{2 * ms}};
  Line line(seven_axes(), timing);
  BOOST_TEST(line.open());
  line.pass({});
  BOOST_TEST(line.pass({4}, ms)[0] == 4.0);
  BOOST_TEST(line.after(ms)[0] == 4.0);  // two cycles old
  BOOST_TEST(line.after(ms / 10)[0] == 0.0);
  BOOST_TEST(line.report.expiries == 1U);
  BOOST_TEST(line.after(5 * ms)[0] == 0.0);
  BOOST_TEST(line.cycle.metrics().expired.value() == 2);
  // It is there again by a quarter of itself a millisecond.
  for (const double part : {1.0, 2.0, 3.0, 4.0, 4.0}) BOOST_TEST(std::abs(line.pass({4}, ms)[0] - part) < 1e-12);
  BOOST_TEST(line.report.expiries == 1U);
  BOOST_TEST(line.report.cuts == 1U);  // of the opening
  // Much later it is cut: the loop has stopped, and must command zero before a force comes back.
  BOOST_TEST(line.after(51 * ms)[0] == 0.0);
  BOOST_TEST(line.report.cuts == 2U);
  BOOST_TEST(line.pass({4}, ms)[0] == 0.0);
  line.pass({}, ms);
  BOOST_TEST(line.pass({4}, ms)[0] == 4.0);
}

BOOST_AUTO_TEST_CASE(a_loop_that_is_late_again_and_again_is_cut) {
  Line line(seven_axes(), {.age_max = Duration{50 * ms}, .expires_after = Duration{2 * ms}});
  BOOST_TEST(line.open());
  line.pass({});
  int expired = 0;
  for (; line.report.cuts == 1U && expired < 100; ++expired) {
    line.pass({4}, ms);
    line.after(2 * ms);
  }
  BOOST_TEST(expired == 11);
  BOOST_TEST(line.pass({4}, ms)[0] == 0.0);
  // Now and then is no more than late.
  line.pass({}, ms);
  for (int i = 0; i < 50; ++i) {
    line.pass({4}, ms);
    line.after(2 * ms);
    for (int k = 0; k < 150; ++k) line.pass({4}, ms);
  }
  BOOST_TEST(line.report.cuts == 2U);
}

BOOST_AUTO_TEST_CASE(a_device_that_is_not_ready_is_not_believed) {
  Line line(seven_axes());
  BOOST_TEST(line.open());
  LinkSample sample;
  sample.R_BD = {0, 0, 0, 0};
  BOOST_TEST((line.show(sample).verdict == Plausibility::Verdict::jumped));
  sample.R_BD = from_rotation_vector({0, 1, 0});
  sample.q[0] = 0.05;
  BOOST_TEST((line.show(sample).verdict == Plausibility::Verdict::good));
  BOOST_TEST(line.cycle.metrics().jumps.value() == 0);
}

BOOST_AUTO_TEST_CASE(a_zero_does_not_expire) {
  const CommandTiming timing{.expires_after = Duration{2 * ms}};
  Line line(seven_axes(), timing);
  BOOST_TEST(line.open());
  line.pass({});
  for (int i = 0; i < 20; ++i) BOOST_TEST(line.after(ms)[0] == 0.0);
  BOOST_TEST(line.report.expiries == 0U);
  BOOST_TEST(line.pass({4}, ms)[0] == 4.0);
}

BOOST_AUTO_TEST_SUITE_END()
