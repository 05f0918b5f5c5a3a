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

BOOST_AUTO_TEST_CASE(points_are_on_the_curve_of_their_method_and_swaps) {
  StudySpec spec;
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
  const WorkPrecision found = work_precision(make_study(spec, comparison));
  BOOST_REQUIRE(found.graphs.size() == 1U);
  const std::vector<WorkPoint>& all = found.graphs[0].points;
  BOOST_TEST(all[1].curve == "hold");
  BOOST_TEST(all[1].values == "x.p=2");
  BOOST_TEST(all[2].curve == "line");
  const std::vector<bool> front{all[0].front_run, all[1].front_run, all[2].front_run, all[3].front_run};
  BOOST_CHECK(front == std::vector<bool>({false, false, true, true}));
}
