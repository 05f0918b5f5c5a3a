// The page of a run: what it shows first, with a reference and without one.
#include "app/report/run_report.hpp"

#include <boost/test/unit_test.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/report/figure.hpp"
#include "app/report/method_style.hpp"
#include "tests/support/page_text.hpp"

BOOST_AUTO_TEST_SUITE(run_report_test)

using namespace tactor;
using namespace tactor::test;

namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

/// A run of 1 s whose commanded force is 1 N along x, and 0.5 N off the reference from 0.5 s on.
RunResult judged_run() {
  RunResult run;
  run.graph = "wall_off";
  run.duration_s = run.planned_s = 1;
  run.wall_s = 0.1;
  const std::vector<double> time{0, 0.25, 0.5, 0.75, 1}, zero(5, 0.0), one(5, 1.0), off{1, 1, 0.5, 0.5, 0.5};
  const auto add = [&](const char* name, const std::vector<double>& value) {
    run.series.push_back({name, "N", time, value});
  };
  add("commanded.x", one);
  add("commanded.y", zero);
  add("commanded.z", zero);
  add("commanded.norm", one);
  add("reference.x", off);
  add("reference.y", zero);
  add("reference.z", zero);
  add("reference.norm", off);
  run.reference.made = true;
  run.metrics = {{"judged.from_s", 0.25}};
  return run;
}

/// The names of a page's figures in their order, each followed by a blank.
std::string figures_in(const std::string& html) {
  std::string names;
  for (const NamedFigure& figure : figures_of(html)) names += figure.name + " ";
  return names;
}

Chart chart_named(const std::string& html, const std::string& name) {
  for (NamedFigure& figure : figures_of(html)) {
    if (figure.name == name) return std::get<std::vector<Chart>>(figure.drawing).front();
  }
  BOOST_FAIL("no figure " + name);
  return {};
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_page_of_a_run_begins_with_its_headline) {
  RunResult run;
  run.graph = "g_h";
  run.duration_s = run.planned_s = 1;
  run.wall_s = 0.5;
  run.metrics = {{"delivered.force.rms_error_N", 0.1}, {"delivered.force.max_error_N", 0.3},
                 {"delivered.force.delay_ms", 4},      {"delivered.force.rms_d2_N_per_ms2", 0.002},
                 {"delivered.force.max_step_N", 0.04}, {"device.engaged_share", 0.9}};
  run.declared.emplace("delivered.force.delay_ms",
                       MetricInfo{"delivered.force.delay_ms", "ms", "delay behind it", Better::lower});
  const std::string html = run_report(run);
  const std::string text = text_of(replaced(html, "</th><td>", ": "));
  for (const char* told : {"Done, 1 s.", "Error: force 0.100 N RMS, 0.300 N at most", "Delay: 4 ms",
                           "Smooth: 0.00200 N/ms² RMS second difference; largest step 0.0400 N",
                           "Gate: limited nothing; let the force through 90 % of the time", "Run time: 0.500 s"}) {
    says(text, told);
  }
  says(html, "<abbr tabindex=\"0\" title=\"delay behind it, ms; lower is better\">Delay</abbr>");
  run.metrics.insert(run.metrics.end(),
                     {{"device.clamped_ticks", 3}, {"device.faults", 1}, {"device.causes.dead_man", 2}});
  run.failure = "it broke";
  const std::string failed = text_of(replaced(run_report(run), "</th><td>", ": "));
  says(failed, "Failed after 1 s.");
  says(failed,
       "Gate: ticks beyond the largest force: 3, faults: 1, dead_man: 2; let the force through 90 % of the time");
}

BOOST_AUTO_TEST_CASE(the_page_of_a_run_shows_the_error_beside_the_force_and_what_a_hand_notices) {
  const std::string html = run_report(judged_run());
  BOOST_TEST(figures_in(html) == "error judged_force zoom force ");
  const Chart error = chart_named(html, "error");
  BOOST_TEST(error.curves.at(0).name == "what a hand notices");
  BOOST_TEST(error.curves.at(1).name == "error");
  BOOST_TEST(error.curves[1].y == (std::vector<double>{0, 0.5, 0.5, 0.5}), boost::test_tools::per_element());
  BOOST_TEST((error.x_range == std::pair{0.25, 1.0}));
  // 40 mN below 0.2 N, by the curve that docs/reference/metrics.md shows; it grows with the force.
  BOOST_TEST(error.curves[0].y[0] > error.curves[0].y[3]);
  // The method has its colour.
  BOOST_TEST(error.curves[1].color == method_styles({"wall_off"}).front().color);
  says_not(html, "No error is shown");
}

BOOST_AUTO_TEST_CASE(a_page_without_a_reference_says_so_and_shows_what_there_is) {
  RunResult run;
  run.graph = "g";
  run.duration_s = run.planned_s = 1;
  run.live.emplace();
  run.live->now = Time{} + Duration{1'000'000'000};
  BOOST_TEST(figures_in(run_report(run)).empty());
  DeviceTrace device;
  device.device = "device";
  device.force = {"force", "N", {0, 1}, {0, 2}};
  device.displacement = {"displacement", "m", {0, 1}, {0, 0.01}};
  device.gate = {"gate", "1", {0, 1}, {0, 1}};
  device.events = {{0.4, SafetyCause::stale}, {0.6, SafetyCause::overspeed}, {0.8, SafetyCause::stale}};
  run.trace.devices = {device};
  const std::string html = run_report(run);
  BOOST_TEST(figures_in(html) == "force displacement gate ");
  says(html, "No error is shown: nothing in the graph asks for a reference");
  const Chart gate = chart_named(html, "gate");
  BOOST_REQUIRE(gate.curves.size() == 3U);
  BOOST_TEST(gate.curves[1].name == "overspeed");
  BOOST_TEST(gate.curves[1].x == std::vector<double>{0.6});
  BOOST_TEST(gate.curves[2].name == "stale");
  BOOST_TEST((gate.curves[2].x == std::vector<double>{0.4, 0.8}));
  // All rows have one time axis.
  for (const char* name : {"force", "displacement", "gate"})
    BOOST_TEST((chart_named(html, name).x_range == std::pair{0.0, 1.0}));
  // Two devices are told apart by their names.
  device.device = "other";
  run.trace.devices.push_back(device);
  BOOST_TEST(chart_named(run_report(run), "force").curves.at(1).name == "other");
}

BOOST_AUTO_TEST_CASE(the_gate_of_a_virtual_run_is_shown_where_something_kept_the_force_out) {
  RunResult run = judged_run();
  DeviceTrace device;
  device.gate = {"gate", "1", {0, 1}, {1, 1}};
  run.trace.devices = {device};
  BOOST_TEST(figures_in(run_report(run)) == "error judged_force zoom force ");
  run.trace.devices.front().events = {{0.5, SafetyCause::not_finite}};
  BOOST_TEST(figures_in(run_report(run)) == "error judged_force zoom force gate ");
}

BOOST_AUTO_TEST_CASE(the_picture_of_a_run_tells_of_which_moment_it_is) {
  Body tool;
  tool.name = "tool";
  tool.motion = Motion::translation;
  tool.shape = SphereShape{0.01};
  GraphSpec graph;
  graph.scene.bodies = {tool};
  RunResult run = judged_run();
  says(run_report(run, &graph), "The scene as the run begins.");
  run.trace.largest.emplace(LargestForce{0.75, {0, 3, 4}, {Pose{{0, 0, 0.1}, {}}}});
  says(run_report(run, &graph), "The scene at the largest force, 5 N at 0.750 s; the arrow is the force on the hand.");
  // Where it is not known how the scene was then.
  run.trace.largest->X_WB.clear();
  says(run_report(run, &graph), "The scene as the run begins.");
}

BOOST_AUTO_TEST_SUITE_END()
