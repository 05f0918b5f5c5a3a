// How far run times can be trusted, from made-up times.
#include "app/run/timing.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

BOOST_AUTO_TEST_SUITE(timing_test)

using namespace tactor;

BOOST_AUTO_TEST_CASE(repeats_spread_by_longest_less_shortest_over_their_median) {
  BOOST_TEST(spread_of_repeats(std::vector<double>{10, 8, 11, 9, 12}) == 0.4);
  BOOST_TEST(std::isnan(spread_of_repeats(std::vector<double>{10})));
  BOOST_TEST(std::isnan(spread_of_repeats(std::vector<double>{})));
  BOOST_TEST(percent(0.404) == "40 %");
  BOOST_TEST(percent(spread_of_repeats(std::vector<double>{10})) == "-");
}

BOOST_AUTO_TEST_CASE(several_repeats_are_warmed_up_and_a_single_run_is_not) {
  BOOST_TEST(warmed_up(1).warm_up == 0);
  BOOST_TEST(warmed_up(3).warm_up == 1);
  BOOST_TEST(warmed_up(3).count == 3);
}

BOOST_AUTO_TEST_CASE(a_spread_of_more_than_a_tenth_warns) {
  const std::vector<double> quiet{100, 101, 100, 99};
  const std::vector<double> spreads{0.01, 0.02, 0.3};
  BOOST_TEST(spread_warning(spreads) == "the repeats of 1 of 3 runs spread by more than 10 %, by 30 % at most");
  BOOST_TEST(spread_warning(std::vector<double>{0.01, 0.1, std::nan("")}).empty());
  BOOST_TEST(timing_note(quiet, spreads, warmed_up(3), "").warning.empty());
  const TimingNote note = timing_note(quiet, spreads, warmed_up(3), spread_warning(spreads));
  BOOST_TEST(note.warning.find("by 30 % at most. Compare") != std::string::npos);
  BOOST_TEST(note.text.find("the median of 3 repeats after 1 run that did not count") != std::string::npos);
  BOOST_TEST(note.text.find("2.0 % in the median and 30.0 % at most") != std::string::npos);
  BOOST_TEST(note.control_us == 100);
  // The fixed computation alone warns too, and what to do is the caller's to say.
  const std::vector<double> loud{100, 100, 150, 150};
  const std::string both = timing_note(loud, {}, warmed_up(1), "one", "wait").warning;
  BOOST_TEST(both.find("one; the fixed computation spread by 40 %") != std::string::npos, both);
  BOOST_TEST(both.find("or wait.") != std::string::npos, both);
}

BOOST_AUTO_TEST_CASE(runs_without_repeats_say_so_and_no_runs_say_nothing) {
  const std::vector<double> quiet{100, 100};
  const std::vector<double> none{std::numeric_limits<double>::quiet_NaN()};
  BOOST_TEST(timing_note(quiet, none, warmed_up(1), "").text.find("a single run each") != std::string::npos);
  const TimingNote nothing = timing_note({}, {}, warmed_up(3), "");
  BOOST_TEST(nothing.text.empty());
  BOOST_TEST(lines_of(nothing).empty());
  BOOST_TEST(to_json(nothing)["control_us"].is_null());
  BOOST_TEST(to_json(nothing)["control_spread"].is_null());
  const TimingNote loud = timing_note(std::vector<double>{100, 200}, none, warmed_up(1), "");
  BOOST_TEST(lines_of(loud, "  ") == "\n  " + loud.text + "\n  " + loud.warning + "\n");
}

BOOST_AUTO_TEST_SUITE_END()
