// The curves of what a hand notices: at their rows, between them, beyond them, and against limits that are known.
#include "framework/core/perception.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <string>

BOOST_AUTO_TEST_SUITE(perception_test)

using namespace tactor;

namespace {

bool close(double found, double expected) {
  return std::abs(found - expected) <= 1e-12 * std::abs(expected);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_weber_curve_goes_through_its_rows_and_every_row_names_its_source) {
  for (const WeberPoint& p : weber_points()) {
    BOOST_TEST(close(force_jnd(p.reference_N), p.jnd_N), p.reference_N << " N");
    BOOST_TEST(std::string(p.source).size() > 20u);
  }
  BOOST_TEST(close(force_jnd(2.5) / 2.5, 0.07));
  BOOST_TEST(close(force_jnd(10) / 10, 0.07));
}

BOOST_AUTO_TEST_CASE(the_noticed_share_grows_towards_low_forces_and_the_difference_never_does) {
  double difference = 0, share = 1e9;
  for (double force = 1e-3; force < 100; force *= 1.1) {
    BOOST_TEST(force_jnd(force) >= difference);
    BOOST_TEST(force_jnd(force) / force <= share * (1 + 1e-12));
    difference = force_jnd(force);
    share = difference / force;
  }
  BOOST_TEST(share == 0.07, boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(between_rows_it_is_a_power_law_and_beyond_them_it_goes_on) {
  // The middle by the logarithm is the geometric mean of both.
  BOOST_TEST(close(force_jnd(std::sqrt(0.04 * 2.5)), std::sqrt(0.04 * 0.175)));
  BOOST_TEST(force_jnd(0) == 0.04);
  BOOST_TEST(force_jnd(0.01) == 0.04);
  BOOST_TEST(close(force_jnd(50), 3.5));
}

BOOST_AUTO_TEST_CASE(the_threshold_of_vibration_goes_through_its_rows_and_keeps_the_displacement_beyond_them) {
  double frequency = 0;
  for (const VibrationPoint& p : vibration_points()) {
    BOOST_TEST(p.frequency_Hz > frequency);
    frequency = p.frequency_Hz;
    BOOST_TEST(close(vibration_threshold(frequency), p.acceleration_m_s2), frequency << " Hz");
    BOOST_TEST(std::string(p.source).size() > 20u);
  }
  BOOST_TEST(close(vibration_threshold(std::sqrt(100. * 125)), std::sqrt(0.023 * 0.022)));
  BOOST_TEST(close(vibration_threshold(630), 4 * vibration_threshold(315)));
  BOOST_TEST(close(vibration_threshold(4), vibration_threshold(8) / 4));
}

BOOST_AUTO_TEST_CASE(a_held_handle_is_a_damper_at_low_and_its_own_mass_at_high_frequencies) {
  for (const ImpedancePoint& p : hand_impedance_points()) {
    BOOST_TEST(close(hand_impedance(p.frequency_Hz), p.impedance_N_s_m), p.frequency_Hz << " Hz");
    BOOST_TEST(std::string(p.source).size() > 20u);
  }
  const double pi = std::numbers::pi;
  BOOST_TEST(close(apparent_mass(20, 0), 14.1 / (40 * pi)));
  BOOST_TEST(close(apparent_mass(1, 0), 14.1 / (2 * pi)));
  BOOST_TEST(apparent_mass(1e4, 0.1) == 0.1, boost::test_tools::tolerance(1e-6));
  // Mass and damper are a quarter of a period apart: at 14.1 = 2 pi f m they are as strong as each other.
  BOOST_TEST(close(apparent_mass(20, 14.1 / (40 * pi)), std::sqrt(2.0) * 14.1 / (40 * pi)));
  BOOST_TEST(close(vibration_force_threshold(100, 0.2), vibration_threshold(100) * apparent_mass(100, 0.2)));
}

BOOST_AUTO_TEST_SUITE_END()
