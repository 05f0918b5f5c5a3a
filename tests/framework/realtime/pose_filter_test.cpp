// The velocity of a pose that is estimated from encoder positions: both its parts, whatever comes and when.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <limits>
#include <utility>

#include "framework/realtime/allocation_watch.hpp"
#include "framework/realtime/pose_filter.hpp"

BOOST_AUTO_TEST_SUITE(pose_filter_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double noise = 1e-5 / 3.4641016151377544;  // m
constexpr double period = 0.001;                     // s
constexpr VelocityFilter kinds[] = {VelocityFilter::mixed, VelocityFilter::several, VelocityFilter::one};

VelocityParams params(VelocityFilter kind) {
  return {2e-6, 2e-5, kind};
}

Time at(double seconds) {
  return Time::from_seconds(seconds);
}

void take(MotionFilter& filter, double interval, double x) {
  filter.take(interval, {x, 0, 0});
}

}  // namespace

BOOST_AUTO_TEST_CASE(constant_velocity_and_constant_acceleration_are_followed_without_steady_error) {
  for (const auto& [kind, a] : {std::pair(VelocityFilter::mixed, 0.0),
                                {VelocityFilter::mixed, 5.0},
                                {VelocityFilter::several, 0.0},
                                {VelocityFilter::several, 5.0}}) {
    PoseFilter filter(params(kind), noise, 1e-4, period, true);
    const Vec3 v{0.3, -0.1, 0.02}, along{1, -2, 0.5};
    for (int k = 0; k <= 3000; ++k) {
      const double t = k * period;
      filter.take({t * v + 0.5 * a * t * t * along, from_rotation_vector({0, 0, 2 * t + a * t * t})}, at(t));
      // A tremor that is not there dies away slowly.
      const double most = kind == VelocityFilter::mixed && t < 2.5 ? 5e-3 : 1e-7;
      if (t < 0.5) continue;
      BOOST_REQUIRE_SMALL(norm(filter.velocity().v - (v + a * t * along)), most);
      BOOST_REQUIRE_SMALL(norm(filter.velocity().w - Vec3{0, 0, 2 + 2 * a * t}), most);
    }
  }
}

BOOST_AUTO_TEST_CASE(rotation_about_a_fixed_axis_is_followed_turn_after_turn) {
  const Vec3 axis{2.0 / 3, -1.0 / 3, 2.0 / 3};
  PoseFilter filter(params(VelocityFilter::several), noise, 1e-4 / 3.4641, period, true);
  MotionFilter angle(2e-5, 1e-4 / 3.4641);
  double expected = 0;
  for (int k = 0; k <= 2000; ++k) {
    const double t = k * period, turn = 25 * t + 0.3 * std::sin(9 * t);  // 8 whole turns
    filter.take({{}, from_rotation_vector(turn * axis)}, at(t));
    if (k == 0) angle.start({});
    if (k > 0) take(angle, period, turn);
    expected = angle.rate().x;
    // The axes are weighted one by one, so that the direction is that of the turn only as far as the models agree.
    if (t > 0.5) BOOST_REQUIRE_SMALL(norm(filter.velocity().w - expected * axis), 2e-3 * std::abs(expected));
  }
  BOOST_TEST(expected == 25 + 2.7 * std::cos(18.0), tt::tolerance(1e-3));
  BOOST_TEST(norm(filter.velocity().v) == 0.0);
}

BOOST_AUTO_TEST_CASE(missed_ticks_times_that_stand_still_or_go_back_and_poses_that_are_not_finite_do_no_harm) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const VelocityFilter kind : kinds) {
    PoseFilter filter(params(kind), noise, 1e-4, period, true);
    const Vec3 v{0.2, 0, 0}, w{0, 1, 0};
    const auto pose = [&](double t) { return Pose{t * v, from_rotation_vector(t * w)}; };
    for (int k = 0; k <= 3000; ++k) {
      const double t = k * period;
      if (k % 5 == 3 || (k > 1000 && k < 1200)) continue;  // and 200 ms without any
      if (k % 4 == 1) {
        filter.take({{nan, 0, 0}, {}}, at(t));
        filter.take({{}, {nan, 0, 0, 0}}, at(t));
        filter.take({{0, infinity, 0}, {}}, at(t));
      }
      filter.take(pose(t), at(t));
      const Twist before = filter.velocity();
      filter.take({{1, 1, 1}, {}}, at(t));
      filter.take({{1, 1, 1}, {}}, at(t - 0.002));
      BOOST_REQUIRE((filter.velocity().v == before.v && filter.velocity().w == before.w));
      // After the long gap the mixed one is the mean of the chains for a while, and its tremors begin anew.
      const bool mixed = kind == VelocityFilter::mixed;
      if (t < 0.4 || (mixed && t > 1 && t < 1.6)) continue;
      BOOST_REQUIRE_SMALL(norm(before.v - v) + norm(before.w - w), mixed ? 5e-3 : 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_pose_that_does_not_rotate_has_no_angular_velocity_and_nothing_allocates) {
  for (const VelocityFilter kind : kinds) {
    PoseFilter filter(params(kind), noise, 1e-4, period, false);
    const std::int64_t before = thread_heap_calls();
    for (int k = 0; k < 100; ++k)
      filter.take({{1e-4 * k, 0, 0}, from_rotation_vector({0.01 * k, 0, 0})}, at(k * period));
    const std::int64_t calls = thread_heap_calls() - before;
    BOOST_TEST((filter.velocity().w == Vec3{}));
    BOOST_TEST(filter.velocity().v.x > 0.09);
    BOOST_TEST(calls == 0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
