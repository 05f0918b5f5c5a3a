// Values between samples against straight lines and a steady screw that are known in closed form.
#include "framework/core/between_samples.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <deque>
#include <vector>

#include "framework/core/messages.hpp"

BOOST_AUTO_TEST_SUITE(between_samples_test)

using namespace tactor;

namespace {

struct Sample {
  Time t;
  double value = 0;
};

Time ms(std::int64_t n) {
  return Time{n * 1'000'000};
}

}  // namespace

BOOST_AUTO_TEST_CASE(between_two_samples_the_value_is_on_the_line_whatever_their_spacing) {
  // The line x = 3 - 2 t, with t in s, at uneven times.
  std::deque<Sample> samples;
  for (const std::int64_t n : {10, 11, 15, 40, 41}) samples.push_back({ms(n), 3 - 2e-3 * static_cast<double>(n)});
  std::size_t cursor = 0;
  for (std::int64_t n = 10; n <= 41; ++n) {
    const double x = value_between(samples, ms(n), cursor, &Sample::t, &Sample::value);
    BOOST_TEST(std::abs(x - (3 - 2e-3 * static_cast<double>(n))) < 1e-15, n);
    BOOST_TEST((samples[cursor].t <= ms(n)));
  }
}

BOOST_AUTO_TEST_CASE(outside_of_the_samples_the_first_and_the_last_one_hold) {
  const std::vector<Sample> samples{{ms(2), 5}, {ms(4), 7}};
  std::size_t cursor = 0;
  BOOST_TEST(value_between(samples, ms(1), cursor, &Sample::t, &Sample::value) == 5);
  BOOST_TEST(value_between(samples, ms(2), cursor, &Sample::t, &Sample::value) == 5);
  BOOST_TEST(value_between(samples, ms(4), cursor, &Sample::t, &Sample::value) == 7);
  BOOST_TEST(value_between(samples, ms(9), cursor, &Sample::t, &Sample::value) == 7);
  const std::vector<Sample> one{{ms(2), 5}};
  for (const std::int64_t n : {1, 2, 3}) {
    cursor = 0;
    BOOST_TEST(value_between(one, ms(n), cursor, &Sample::t, &Sample::value) == 5);
  }
}

BOOST_AUTO_TEST_CASE(between_two_poses_the_motion_is_a_steady_turn_the_shorter_way) {
  // From 20 to 340 degrees about z the shorter way is 40 degrees backwards, through 0.
  const double degree = std::acos(-1.0) / 180;
  const auto about_z = [&](double angle) {
    return Quat{std::cos(angle * degree / 2), 0, 0, std::sin(angle * degree / 2)};
  };
  const Pose a{{1, 2, 3}, about_z(20)}, b{{3, 2, -1}, about_z(340)};
  for (const double share : {0.0, 0.25, 0.5, 1.0}) {
    const Pose X = between(a, b, share);
    BOOST_TEST(norm(X.p - Vec3{1 + 2 * share, 2, 3 - 4 * share}) < 1e-15);
    const Vec3 off = to_rotation_vector(X.R * inverse(about_z(20 - 40 * share)));
    BOOST_TEST(norm(off) < 1e-15, share);
  }
}

BOOST_AUTO_TEST_CASE(the_share_of_the_way_is_exact_to_rounding_for_times_of_nanoseconds) {
  BOOST_TEST(share_between(Time{7}, Time{11}, Time{8}) == 0.25);
  BOOST_TEST(share_between(Time{-2}, Time{2}, Time{0}) == 0.5);
}

BOOST_AUTO_TEST_SUITE_END()
