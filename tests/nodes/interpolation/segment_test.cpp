// A segment's value and derivatives against the quintic written out in time.
#include "framework/core/segment.hpp"

#include <boost/test/unit_test.hpp>

BOOST_AUTO_TEST_SUITE(segment_test)

using namespace tactor;

namespace {

// F_x(t) = 2 - t + 3 t^2 + 0.5 t^3 - 0.25 t^4 + 0.125 t^5 with t in s from 1 s to 3 s; s = t' / 2 with t' from the
// begin.
ForceSegment example() {
  ForceSegment segment{Time::from_seconds(1), Time::from_seconds(3), {}};
  segment.c[0].force.x = 2;
  segment.c[1].force.x = -1 * 2;
  segment.c[2].force.x = 3 * 4;
  segment.c[3].force.x = 0.5 * 8;
  segment.c[4].force.x = -0.25 * 16;
  segment.c[5].force.x = 0.125 * 32;
  return segment;
}

}  // namespace

BOOST_AUTO_TEST_CASE(value_and_derivatives_are_those_of_the_quintic_in_seconds) {
  const ForceSegment segment = example();
  for (const double t : {0.0, 0.25, 1.0, 1.9}) {
    const Time now = Time::from_seconds(1 + t);
    const double t2 = t * t;
    const double value = 2 - t + 3 * t2 + 0.5 * t2 * t - 0.25 * t2 * t2 + 0.125 * t2 * t2 * t;
    const double rate = -1 + 6 * t + 1.5 * t2 - t2 * t + 0.625 * t2 * t2;
    const double curvature = 6 + 3 * t - 3 * t2 + 2.5 * t2 * t;
    BOOST_TEST(std::abs(evaluate(segment, now).force.x - value) < 1e-12);
    BOOST_TEST(std::abs(evaluate_rate(segment, now).force.x - rate) < 1e-12);
    BOOST_TEST(std::abs(evaluate_curvature(segment, now).force.x - curvature) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(the_ends_are_held) {
  const ForceSegment segment = example();
  BOOST_TEST(evaluate(segment, Time{0}).force.x == 2.0);
  BOOST_TEST(std::abs(evaluate(segment, Time::from_seconds(9)).force.x - (2 - 2 + 12 + 4 - 4 + 4)) < 1e-12);
  BOOST_TEST(evaluate_rate(segment, Time::from_seconds(9)).force.x == 0.0);
  BOOST_TEST(evaluate_curvature(segment, Time{0}).force.x == 0.0);
}

BOOST_AUTO_TEST_CASE(a_constant_has_no_length_and_one_value) {
  const ForceSegment segment = constant_segment(Time{5}, {{1, 2, 3}, {4, 5, 6}});
  for (const std::int64_t ns : {0, 5, 500}) {
    BOOST_TEST(evaluate(segment, Time{ns}).force.y == 2.0);
    BOOST_TEST(evaluate(segment, Time{ns}).torque.z == 6.0);
    BOOST_TEST(norm(evaluate_rate(segment, Time{ns}).force) == 0.0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
