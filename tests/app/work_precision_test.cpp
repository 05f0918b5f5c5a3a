// Fronts and spreads of a work-precision diagram, worked out by hand.
#include "app/study/report/work_precision.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(work_precision_test)

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
  // One value has a centre, and no deviation.
  const Spread one = spread_of(std::vector<double>{4});
  BOOST_TEST(std::abs(one.centre - 4) < 1e-12);
  BOOST_TEST(!one.has_sides());
}

namespace {

constexpr std::size_t wide = 1000;  // columns, so that nothing is folded

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

BOOST_AUTO_TEST_CASE(the_direction_and_the_unit_of_the_error_are_those_that_are_declared) {
  Study study = two_methods({}, StudyTime::both);
  MetricInfo& error = study.comparison.declared["delivered.force.rms_error_N"];
  error = {"delivered.force.rms_error_N", "N/ms^2", "something", Better::higher};
  const WorkPrecision found = work_precision(study);
  BOOST_TEST(found.error_label == "something, N/ms²");
  BOOST_CHECK(front_of(found.graphs[0].points) == std::vector<bool>({true, false, false, false}));
  error.better = Better::lower;
  BOOST_CHECK(front_of(work_precision(study).graphs[0].points) == std::vector<bool>({false, false, true, true}));
}

BOOST_AUTO_TEST_CASE(points_without_a_reference_are_on_no_front_whatever_the_error_is) {
  Study study = two_methods({}, StudyTime::both);
  study.spec.error = study.comparison.columns[0].metric = "delivered.force.rms_d2_N_per_ms2";
  BOOST_CHECK(front_of(work_precision(study).graphs[0].points) == std::vector<bool>({false, false, false, false}));
  for (CompareRow& row : study.comparison.rows) row.runs[0].metrics = {{"reference.rate_hz", 10000}};
  BOOST_CHECK(front_of(work_precision(study).graphs[0].points) == std::vector<bool>({false, false, true, true}));
}

BOOST_AUTO_TEST_CASE(bounds_are_on_no_front_and_undercut_nothing) {
  const WorkPrecision found = work_precision(two_methods({"line"}, StudyTime::both));
  const std::vector<WorkPoint>& all = found.graphs[0].points;
  BOOST_TEST(!all[0].bound);
  BOOST_TEST(all[2].bound);
  // Without `line`, the other method's points are the best there are.
  BOOST_CHECK(front_of(all) == std::vector<bool>({true, true, false, false}));
}

BOOST_AUTO_TEST_CASE(a_point_that_lacks_seeds_shows_the_others_and_is_on_no_front) {
  Study study = two_methods({}, StudyTime::both);
  study.comparison.seeds = {1, 2, 3};
  for (CompareRow& row : study.comparison.rows) {
    row.status.assign(3, RunStatus::done);
    row.message.assign(3, "");
    row.runs.resize(3);
    row.spread.assign(3, 0.01);
    row.control_us.assign(3, 1000);
    for (std::vector<double>& values : row.values) values.assign(3, values.front());
  }
  // The best point of all, in error and in time, has errors 0.5, 2 N and none.
  CompareRow& best = study.comparison.rows[3];
  best.values[0] = {0.5, std::nan(""), 2};
  best.values[1] = {0.5, std::nan(""), 0.5};
  best.status[1] = RunStatus::failed;
  best.message[1] = "it broke";
  const WorkPrecision found = work_precision(study);
  const std::vector<WorkPoint>& all = found.graphs[0].points;
  BOOST_TEST(all[3].incomplete());
  BOOST_TEST(all[3].seeds_done == 2U);
  BOOST_TEST(std::abs(all[3].error.centre - 1) < 1e-12);
  BOOST_TEST(!all[2].incomplete());
  // It is not marked as best, nor does it take that from the others.
  BOOST_CHECK(front_of(all) == std::vector<bool>({false, false, true, false}));
  BOOST_TEST(work_precision_table(study, found, wide).find("2 of 3 seeds") != std::string::npos);
  const TemporaryFolder folder;
  const std::string page = write_work_precision(folder.path(), study, found);
  for (const char* text : {"incomplete: seeds failed", "not undercut (complete)", "2 of 3 seeds",
                           "A cross marks a method that lacks seeds", "it broke"}) {
    BOOST_TEST(page.find(text) != std::string::npos, text);
  }
  BOOST_TEST(to_json(found)["graphs"][0]["points"][3]["seeds_done"] == 2);
  // Nothing of this is said where nothing is missing.
  const Study whole = two_methods({}, StudyTime::both);
  const std::string plain = write_work_precision(folder.path(), whole, work_precision(whole));
  BOOST_TEST(plain.find("incomplete") == std::string::npos);
  BOOST_TEST(plain.find("A cross") == std::string::npos);
}

BOOST_AUTO_TEST_CASE(one_seed_has_neither_bars_nor_brackets) {
  Study study = two_methods({}, StudyTime::run);
  const auto svg = [&study] {
    const TemporaryFolder folder;
    write_work_precision(folder.path(), study, work_precision(study));
    std::ifstream file(folder.path() / "work_precision_a.svg");
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const auto count = [](const std::string& text, const std::string& what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
    return found;
  };
  // In the group of a curve gnuplot draws a mark as a use of its shape, lines and bars as strokes, each with a move.
  const auto strokes = [&count](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = text.find("<g id=\"gnuplot_plot_"); at != std::string::npos;
         at = text.find("<g id=\"gnuplot_plot_", at + 1)) {
      found += count(text.substr(at, text.find("</g>\n\t</g>", at) - at), "M");
    }
    return found;
  };
  const WorkPrecision one = work_precision(study);
  const auto json = to_json(one)["graphs"][0]["points"][0]["error"];
  BOOST_TEST(std::abs(json["centre"].get<double>() - 4) < 1e-12);
  BOOST_TEST(json["low"].is_null());
  BOOST_TEST(json["high"].is_null());
  BOOST_TEST(work_precision_table(study, one, wide).find('[') == std::string::npos,
             work_precision_table(study, one, wide));
  BOOST_TEST(to_json(study)["rows"][0]["metrics"]["delivered.force.rms_error_N"]["sd"].is_null());
  const std::string bare = svg();
  // The same over two seeds of which the second has twice the error and the time.
  study.comparison.seeds = {1, 2};
  for (CompareRow& row : study.comparison.rows) {
    row.runs.resize(2);
    row.status.assign(2, RunStatus::done);
    row.message.assign(2, "");
    row.spread = row.control_us = {1, 1};
    for (std::vector<double>& values : row.values) values.push_back(2 * values.front());
  }
  BOOST_TEST(to_json(study)["rows"][0]["metrics"]["delivered.force.rms_error_N"]["sd"].is_number());
  const std::string barred = svg();
  const auto halos = count(barred, ")' color='#FFFFFF'");  // gnuplot 6 draws one behind each mark with bars
  BOOST_TEST(count(barred, "<use") - halos == count(bare, "<use"));
  BOOST_TEST(strokes(bare) == 4U);  // the line through each method's marks, and its sample in the key
  BOOST_TEST(strokes(barred) > 4U);
  // A curve of both kinds has all of its marks: the second point has lost its second seed.
  study.comparison.rows[1].status[1] = RunStatus::failed;
  const std::string mixed = svg();
  BOOST_TEST(strokes(mixed) > 4U);
  BOOST_TEST(strokes(mixed) < strokes(barred));
  BOOST_TEST(count(mixed, ">hold</text>") == 1U);
}

BOOST_AUTO_TEST_CASE(a_chart_has_the_error_upwards_and_its_key_names_methods_by_colour_and_values_by_marks) {
  Study study = two_methods({}, StudyTime::run);
  study.spec.metrics = {"cpu_ms_per_s"};
  const TemporaryFolder folder;
  const std::string html = write_work_precision(folder.path(), study, work_precision(study));
  const std::size_t run_time = html.find(">CPU ms per simulated second</text>");
  const std::string error = ">" + work_precision(study).error_label + "</text>";
  const std::size_t upwards = html.find(error);
  BOOST_REQUIRE(run_time != std::string::npos);
  BOOST_REQUIRE(upwards != std::string::npos);
  // A label along y is turned.
  const auto is_turned = [&](std::size_t at) {
    const std::size_t group = html.rfind("<g transform=", at);
    return html.substr(group, html.find('>', group) - group).find("rotate(") != std::string::npos;
  };
  BOOST_TEST(is_turned(upwards));
  BOOST_TEST(!is_turned(run_time));
  for (const char* name : {"hold", "line", "x.p=1", "x.p=2"}) {
    BOOST_TEST(html.find(">" + std::string(name) + "</text>") != std::string::npos, name);
  }
  // The metric that the study names.
  BOOST_TEST(html.find("<div class=\"wide\"><table class=\"rows\">") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(over_all_graphs_bars_are_over_seeds) {
  StudySpec spec;
  spec.graphs = {"a.yaml", "b.yaml"};
  Comparison comparison;
  comparison.seeds = {1, 2, 3};
  comparison.columns = {{"delivered.force.rms_error_N", "error"}, {"cpu_ms_per_s", "time", true}};
  // By seed the geometric means over the graphs are 2, 8 and (where both are done) 4.
  const std::vector<std::vector<double>> errors{{1, 4, 2}, {4, 16, 8}};
  for (std::size_t g = 0; g < 2; ++g) {
    CompareRow row;
    row.graph = g == 0 ? "a" : "b";
    row.against = g;
    row.runs.resize(3);
    row.status.assign(3, RunStatus::done);
    row.message.assign(3, "");
    row.spread = row.control_us = {1, 1, 1};
    row.values = {errors[g], {1, 1, 1}};
    comparison.rows.push_back(row);
  }
  const WorkPrecision found = work_precision(make_study(spec, comparison));
  BOOST_REQUIRE(found.graphs.size() == 3U);
  const Spread all = found.graphs[2].points[0].error;
  BOOST_TEST(found.graphs[2].graph == "all 2 graphs");
  // Logarithms ln 2, ln 8, ln 4: mean ln 4, sample deviation ln 2. The graphs, at 2 and 8, would be a deviation of 1.41
  // times that apart.
  BOOST_TEST(std::abs(all.centre - 4) < 1e-12);
  BOOST_TEST(std::abs(all.low - 2) < 1e-12);
  BOOST_TEST(std::abs(all.high - 8) < 1e-12);
  // A seed that one graph lacks is not among those over all: ln 2 and ln 8 are left.
  comparison.rows[1].status[2] = RunStatus::failed;
  comparison.rows[1].values[0][2] = comparison.rows[1].values[1][2] = std::nan("");
  const WorkPoint point = work_precision(make_study(spec, comparison)).graphs[2].points[0];
  BOOST_TEST(point.seeds_done == 2U);
  BOOST_TEST(std::abs(point.error.centre - 4) < 1e-12);
  BOOST_TEST(std::abs(point.error.high - 4 * std::pow(2, std::sqrt(2))) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_run_time_that_is_not_shown_has_no_front) {
  const WorkPrecision found = work_precision(two_methods({}, StudyTime::tick));
  BOOST_CHECK(front_of(found.graphs[0].points) == std::vector<bool>(4, false));
}

BOOST_AUTO_TEST_SUITE_END()
