// Fronts and spreads of a work-precision diagram, worked out by hand.
#include "app/study/work_precision.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <vector>

using namespace tactor;

BOOST_AUTO_TEST_CASE(a_front_holds_what_nothing_undercuts) {
  const double nan = std::nan("");
  //                              front  beaten by 0  front  same x as 2  front  none
  const std::vector<double> error{1.0, 1.5, 0.5, 0.5, 0.1, nan};
  const std::vector<double> time{1.0, 1.0, 2.0, 3.0, 9.0, 0.1};
  const std::vector<bool> expected{true, false, true, false, true, false};
  BOOST_CHECK(pareto_front(error, time) == expected);
  // Two that are alike do not undercut each other.
  const std::vector<double> same{1.0, 1.0};
  BOOST_CHECK(pareto_front(same, same) == std::vector<bool>({true, true}));
}

BOOST_AUTO_TEST_CASE(a_spread_is_the_geometric_mean_and_deviation) {
  // Logarithms ln 1, ln 4: mean ln 2, sample deviation sqrt(2) ln 2.
  const Spread found = spread_of(std::vector<double>{1, 4});
  BOOST_TEST(std::abs(found.centre - 2) < 1e-12);
  BOOST_TEST(std::abs(found.high - 2 * std::pow(2, std::sqrt(2))) < 1e-12);
  BOOST_TEST(std::abs(found.low * found.high - 4) < 1e-12);
  BOOST_TEST(std::isnan(spread_of(std::vector<double>{1, 0}).centre));
}

namespace {

/// Two methods at two values each, the first without an error below 3.
Study two_methods(const std::vector<std::string>& bounds, StudyTime shown) {
  StudySpec spec;
  spec.bounds = bounds;
  spec.time = shown;
  spec.graphs = {"a.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  spec.vary = {{"x.p", {"x.p"}, {{"1", {}, {}}, {"2", {}, {}}}, {}}};
  Comparison comparison;
  comparison.seeds = {1};
  comparison.columns = {{"delivered.force.rms_error_N", "error"}, {"cpu_ms_per_s", "time", true}};
  const std::vector<std::pair<double, double>> points{{4, 1}, {3, 2}, {2, 1}, {1, 2}};
  for (const auto& [error, time] : points) {
    CompareRow row;
    row.graph = "a";
    row.runs.resize(1);
    row.status.assign(1, RunStatus::done);
    row.message.assign(1, "");
    row.spread = row.control_us = {1.0};
    row.values = {{error}, {time}};
    comparison.rows.push_back(row);
  }
  return make_study(spec, comparison);
}

std::vector<bool> front_of(const std::vector<WorkPoint>& points) {
  std::vector<bool> front;
  for (const WorkPoint& p : points) front.push_back(p.front_run);
  return front;
}

}  // namespace

BOOST_AUTO_TEST_CASE(points_are_on_the_curve_of_their_method_and_swaps) {
  const WorkPrecision found = work_precision(two_methods({}, StudyTime::both));
  BOOST_REQUIRE(found.graphs.size() == 1U);
  const std::vector<WorkPoint>& all = found.graphs[0].points;
  BOOST_TEST(all[1].curve == "hold");
  BOOST_TEST(all[1].values == "x.p=2");
  BOOST_TEST(all[2].curve == "line");
  BOOST_CHECK(front_of(all) == std::vector<bool>({false, false, true, true}));
}

BOOST_AUTO_TEST_CASE(bounds_are_on_no_front_and_undercut_nothing) {
  const WorkPrecision found = work_precision(two_methods({"line"}, StudyTime::both));
  const std::vector<WorkPoint>& all = found.graphs[0].points;
  BOOST_TEST(!all[0].bound);
  BOOST_TEST(all[2].bound);
  // Without `line`, the other method's points are the best there are.
  BOOST_CHECK(front_of(all) == std::vector<bool>({true, true, false, false}));
}

BOOST_AUTO_TEST_CASE(a_run_time_that_is_not_shown_has_no_front) {
  const WorkPrecision found = work_precision(two_methods({}, StudyTime::tick));
  BOOST_CHECK(front_of(found.graphs[0].points) == std::vector<bool>(4, false));
}
