// The line that says what a hand is predicted to feel: nothing, or where and how much.
#include "app/run/headline.hpp"

#include <boost/test/unit_test.hpp>
#include <limits>
#include <string>

BOOST_AUTO_TEST_SUITE(headline_test)

using namespace tactor;

namespace {

struct Metrics {
  double weber, jnd, level_dB, band_Hz, worst_dB;
};

std::string felt(const Metrics& metrics) {
  RunResult result;
  result.metrics = {{"delivered.force.share_beyond_weber", metrics.weber},
                    {"delivered.torque.share_beyond_jnd", metrics.jnd},
                    {"delivered.force.vibration_above_threshold_dB", metrics.level_dB},
                    {"delivered.force.vibration_above_threshold_Hz", metrics.band_Hz},
                    {"delivered.force.worst_vibration_above_threshold_dB", metrics.worst_dB}};
  for (const HeadlineLine& line : headline(result)) {
    if (line.name == "felt") return line.text;
  }
  return {};
}

constexpr double none = std::numeric_limits<double>::quiet_NaN();

}  // namespace

BOOST_AUTO_TEST_CASE(nothing_is_felt_only_where_all_is_under_its_threshold) {
  BOOST_TEST(felt({0, 0, -9.2, 100, -4.4}) ==
             "nothing: the force's error is too small; the torque's error is too small; vibration at 100 Hz, 9 dB "
             "under its threshold (4 dB under in the worst half second)");
  BOOST_TEST(felt({0, none, none, none, none}) == "the force's error is too small; vibration was not judged");
  // Vibration in the worst half second alone.
  BOOST_TEST(felt({0, none, -2, 100, 1}) ==
             "vibration at 100 Hz, 2 dB under its threshold (1 dB above in the worst half second)");
}

BOOST_AUTO_TEST_CASE(all_that_is_felt_is_told_with_where_and_how_much) {
  BOOST_TEST(felt({0.05, 0.2, 7, 80, 12}) ==
             "the force's error 5 % of the time; the torque's error 20 % of the time; vibration at 80 Hz, 7 dB above "
             "its threshold (12 dB above in the worst half second)");
  // A short run has no half second.
  BOOST_TEST(felt({0, none, 3, 125, none}) == "vibration at 125 Hz, 3 dB above its threshold");
  BOOST_TEST(felt({0.05, none, -3, 125, -1}) == "the force's error 5 % of the time");
  BOOST_TEST(felt({0.05, none, none, none, none}) == "the force's error 5 % of the time; vibration was not judged");
  BOOST_TEST(felt({0.002, none, -3, 125, -1}) == "the force's error under 1 % of the time");
}

BOOST_AUTO_TEST_CASE(a_run_without_a_reference_says_nothing_of_it) {
  BOOST_TEST(felt({none, none, none, none, none}).empty());
}

BOOST_AUTO_TEST_SUITE_END()
