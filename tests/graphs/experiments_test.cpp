// Experiments with simulated people, from the graph to the table, and what of them is refused before anything moves.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(experiments_test)

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const fs::path simulated = graphs / "experiments/simulated.yaml";
const fs::path observer = graphs / "experiments/observer.yaml";
const fs::path which_is_smoother = graphs / "experiments/which_is_smoother.yaml";
/// The local rollout alone: its force depends on nothing that is drawn.
const Over one_condition{"protocol.conditions.A=select.use=fourth", "protocol.conditions.B=~"};
const Over brief{"protocol.interval=0.1 s", "protocol.change=0.15 s", "observer.response_time=30 ms"};

using Row = std::map<std::string, std::string>;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line + ",");
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

std::vector<Row> rows_of(const fs::path& table) {
  std::istringstream in(text_in(table));
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> heads = cells_of(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = cells_of(line);
    BOOST_REQUIRE(cells.size() == heads.size());
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < heads.size(); ++i) row[heads[i]] = cells[i];
  }
  return rows;
}

double number(const Row& row, const std::string& name) {
  return std::stod(row.at(name));
}

/// The interval of a trial without the comparison.
std::string standard_of(const Row& row) {
  return row.at("comparison") == "1" ? "2" : "1";
}

struct Fixture {
  TemporaryFolder folder;

  fs::path table(const std::string& participant) const { return folder.path() / ("tables/" + participant + ".csv"); }

  Plan study(const std::string& participant, const Over& settings, const fs::path& graph = simulated) const {
    return planned(
        graph, Over{"protocol.folder=" + (folder.path() / "tables").string(), "protocol.participant=" + participant} +
                   settings);
  }

  std::vector<Row> rows_of_run(const std::string& participant, const Over& settings) const {
    run(study(participant, settings), {}, {.keeps_tables = true});
    return rows_of(table(participant));
  }

  fs::path file(const std::string& text) const { return write(folder.path() / "study.yaml", text); }

  /// The simulated study with these lines of its protocol.
  fs::path with_protocol(const std::vector<std::string>& lines, const std::string& nodes = "") const {
    std::string text = "format: 2\nextends: " + simulated.string() + "\nnodes:\n" + nodes + "  protocol:\n";
    for (const std::string& line : lines) text += "    " + line + "\n";
    return file(text);
  }
  std::string refusal_with(const std::vector<std::string>& lines, const std::string& nodes = "") const {
    return refusal(with_protocol(lines, nodes));
  }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_staircase_finds_the_threshold_and_its_table_tells_the_same, Fixture) {
  const RunResult result = run(
      study("P01", brief + one_condition + Over{"protocol.reversals=44", "protocol.averaged=40", "observer.slope=5"}),
      {}, {.keeps_tables = true});
  const double found = result.metric("experiment.threshold");
  // 1 up, 3 down with these steps rests at 83.15 %: 1 - exp(-(x / 0.2)^5) = (0.8315 - 0.5) / 0.5. The spread of single
  // runs is 4 %.
  near(found / (0.2 * std::pow(-std::log(1 - 0.663), 0.2)), 1, 0.2);
  const std::vector<Row> rows = rows_of(table("P01"));
  BOOST_TEST(result.metric("experiment.trials") == static_cast<double>(rows.size()));
  std::vector<double> reversals;
  int in_a_row = 0, before = 0;
  for (const Row& row : rows) {
    const bool correct = row.at("correct") == "1";
    BOOST_TEST(row.at("correct") == (row.at("response") == row.at("comparison") ? "1" : "0"));
    in_a_row = correct ? in_a_row + 1 : 0;
    const int direction = !correct ? 1 : in_a_row == 3 ? -1 : 0;
    if (direction == 0) continue;
    in_a_row = 0;
    if (before != 0 && direction != before) reversals.push_back(number(row, "level"));
    before = direction;
  }
  BOOST_TEST_REQUIRE(reversals.size() == 44U);
  double sum = 0;
  std::for_each(reversals.end() - 40, reversals.end(), [&sum](double level) { sum += std::log(level); });
  near(std::exp(sum / 40), found, 5e-10);
}

BOOST_FIXTURE_TEST_CASE(what_is_felt_is_what_the_table_says, Fixture) {
  const std::vector<Row> rows = rows_of_run(
      "P01", one_condition + Over{"protocol.procedure=constant", "protocol.levels=[0.25, 1]", "protocol.repeats=2"});
  BOOST_TEST(rows.size() == 4U);
  for (const Row& row : rows) {
    const double comparison = number(row, "peak_" + row.at("comparison") + "_N");
    const double standard = number(row, "peak_" + standard_of(row) + "_N");
    BOOST_TEST(standard > 0.5);
    near(comparison / standard, 1 + number(row, "level"), 5e-5);
  }
}

BOOST_FIXTURE_TEST_CASE(pairs_are_compared_and_have_no_right_answer, Fixture) {
  run(study("P01",
            Over{observer.string()} + brief +
                Over{"observer.worths=[1, 1, 1, 1e9]", "trajectory.points=[{t: 0 s, z: 8 mm}]",
                     "trajectory.repeat_after=0"},
            which_is_smoother),
      {}, {.keeps_tables = true});
  const std::vector<Row> rows = rows_of(table("P01"));
  BOOST_TEST(rows.size() == 24U);
  for (const Row& row : rows) {
    BOOST_TEST(row.at("level") == "0");
    BOOST_TEST(row.at("correct") == "");
    BOOST_TEST(row.at("block") == "1");
    // In a pair the comparison is the condition that the graph names first.
    BOOST_TEST(row.at("condition") < row.at("other"));
    if (row.at("other") == "D") BOOST_TEST(row.at("response") != row.at("comparison"));
  }
}

/// A hand that never lifts off, though methods and stiffness change: what the device shows follows the ramps of the
/// gain.
BOOST_FIXTURE_TEST_CASE(no_force_steps_while_a_hand_keeps_pressing, Fixture) {
  const fs::path pressing = file("format: 2\nextends: [" + which_is_smoother.string() + ", " + observer.string() + R"(]
duration: 40 s
nodes:
  trajectory: {repeat_after: 0, tremor_amplitude: 0, points: [{t: 0 s, z: 2 mm}]}
  protocol:
    conditions: {A: select.use=first; coupling.k_0=400 N/m, B: select.use=fourth; coupling.k_0=1200 N/m, C: ~, D: ~}
edges: [coupling.force -> protocol.force: ~]
record: [device.commanded, protocol.screen]
)");
  std::vector<Stamped<Wrench>> commanded;
  run(study("P01", brief + Over{"protocol.interval=0.4 s"}, pressing), {kept("device.commanded", commanded)},
      {.keeps_tables = true});
  const std::vector<Row> rows = rows_of(table("P01"));
  BOOST_TEST(rows.size() == 4U);
  std::map<std::string, double> peaks;
  for (const Row& row : rows) {
    for (const std::string i : {"1", "2"}) {
      peaks[row.at(row.at("comparison") == i ? "condition" : "other")] = number(row, "peak_" + i + "_N");
    }
  }
  // The settings of the conditions are felt.
  BOOST_TEST(peaks["B"] > 1.3 * peaks["A"]);
  double most = 0, step = 0;
  for (std::size_t i = 1000; i < commanded.size(); ++i) {
    const double force = commanded[i].value.force.z;
    most = std::max(most, force);
    if (i > 1000) step = std::max(step, std::abs(force - commanded[i - 1].value.force.z));
  }
  // At 1 kHz: a ramp of 0.1 s is at most 1.5 F / 100 a tick. The rest is for the coupling and the change-over of
  // select.
  BOOST_TEST(most > 0.5);
  BOOST_TEST(step < 0.025 * most);
}

BOOST_FIXTURE_TEST_CASE(participants_get_their_own_orders_and_the_same_code_the_same, Fixture) {
  const Over settings = brief + Over{"protocol.procedure=constant", "protocol.levels=[0.1, 0.4]", "protocol.repeats=2"};
  const std::vector<Row> first = rows_of_run("P01", settings), second = rows_of_run("P02", settings),
                         third = rows_of_run("Q01", settings);
  const auto column = [](const std::vector<Row>& rows, const std::string& name) {
    std::vector<std::string> cells;
    for (const Row& row : rows) cells.push_back(row.at(name));
    return cells;
  };
  BOOST_TEST((std::set{first.at(0).at("condition"), second.at(0).at("condition")} == std::set<std::string>{"A", "B"}));
  BOOST_TEST((column(first, "condition") == column(third, "condition")));
  BOOST_TEST(
      (column(first, "level") != column(third, "level") || column(first, "comparison") != column(third, "comparison")));
  const std::string before = text_in(table("P01"));
  fs::remove(table("P01"));
  rows_of_run("P01", settings);
  BOOST_TEST(text_in(table("P01")) == before);
}

BOOST_FIXTURE_TEST_CASE(a_force_that_the_device_limits_is_in_the_table_and_told, Fixture) {
  const Over limited = one_condition + Over{"protocol.procedure=constant", "protocol.levels=[1]", "protocol.repeats=2"};
  double most = 0;
  for (const Row& row : rows_of_run("P01", limited)) {
    BOOST_TEST(row.at("limited_1") == "0");
    BOOST_TEST(row.at("limited_2") == "0");
    most = std::max(most, number(row, "peak_" + row.at("comparison") + "_N"));
  }
  std::ostringstream limit;
  limit.precision(17);
  limit << "device.force_max=" << 0.6 * most << " N";
  const RunResult result = run(study("P02", limited + Over{limit.str()}), {}, {.keeps_tables = true});
  for (const Row& row : rows_of(table("P02"))) {
    // The comparison is twice the standard, which is below the limit.
    BOOST_TEST(number(row, "limited_" + row.at("comparison")) > 0);
    BOOST_TEST(row.at("limited_" + standard_of(row)) == "0");
    near(number(row, "peak_" + row.at("comparison") + "_N") / (0.6 * most), 1, 5e-4);
  }
  std::string told;
  for (const std::string& remark : result.remarks) told += remark + "\n";
  says(told, "in 2 trials the device displayed less force than was wanted");
  BOOST_TEST(result.metric("experiment.limited_trials") == 2);
}

BOOST_FIXTURE_TEST_CASE(a_run_under_the_virtual_clock_comes_out_the_same_however_often, Fixture) {
  const Over settings = brief + Over{"protocol.procedure=constant", "protocol.levels=[0.25]", "protocol.repeats=2"};
  rows_of_run("P01", settings);
  const std::string first = text_in(table("P01"));
  fs::remove(table("P01"));
  rows_of_run("P01", settings);
  BOOST_TEST(text_in(table("P01")) == first);
}

BOOST_FIXTURE_TEST_CASE(a_bad_study_is_refused_with_its_place, Fixture) {
  const std::string error = refusal_with({"conditions:", "  A: select.use=fifth", "  B: select.blend_tim=1",
                                          "  C: device.encoder_step=1 mm", "most: 12", "mute: gain.ramp"});
  const std::vector<std::pair<int, std::string>> errors{
      {6, "fifth"},
      {7, "select.blend_tim=1: the graph has no such parameter; did you mean \"select.blend_time\"?"},
      {8, "device.encoder_step=1 mm: device.simulated reads it only at the start"},
      {10, "gain.ramp=0: interpolation.gain reads it only at the start"}};
  for (const auto& [line, text] : errors) {
    says_like(error, "study\\.yaml:" + std::to_string(line) + ":\\d+: ");
    says(error, text);
  }
  says(error, "expected a number from 0 to 10, found 13");
  const std::vector<std::pair<Over, std::string>> refused{
      {{"protocol.participant=Anna"}, "never a name"},
      {{"protocol.participant=Jan07"}, "one capital letter and then one to three digits"},
      {{"protocol.steps=[]"}, "expected a list of steps"},
      {{"protocol.conditions.hold=select.use=first"}, "a letter and up to three digits"},
      {{"protocol.participant=P0", "protocol.resume=true"}, "for practice"}};
  for (const auto& [settings, text] : refused) says(refusal(simulated, settings), text);
  // A condition that no edge feeds is found before anything moves.
  const fs::path unfed =
      file("format: 2\nextends: " + simulated.string() + "\nedges: [rollout.segment -> select.fourth: ~]\n");
  says_like(refusal_of([&] { execute(study("P01", {}, unfed), {.keeps_tables = true}); }),
            R"(stiffness_jnd\.yaml:\d+:\d+: nodes\.protocol\.conditions\.B: .*no edge ends at that input)");
}

BOOST_FIXTURE_TEST_CASE(what_would_not_be_felt_as_it_is_set_is_refused_with_both_places, Fixture) {
  std::string text = "format: 2\nextends: " + simulated.string() + R"(
nodes:
  device: {dead_man_button: 2}
  gain: {ramp: 0.8 s}
  protocol:
    button_first: 1
    button_second: 2
    conditions:
      A: select.use=first; coupling.k_0=500 N/m
      B: select.use=fourth; coupling.k_0=2 N/mm
)";
  const std::string error = refusal(file(text));
  says_like(error,
            R"(study\.yaml:8:\d+: nodes\.protocol\.button_second: .*nodes\.device\.dead_man_button, .*study\.yaml:4:)");
  says_like(
      error,
      R"(simulated\.yaml:\d+:\d+: nodes\.protocol\.change: expected at least 800 ms, the ramp of gain .*study\.yaml:5:)");
  text = replaced(replaced(text, "{dead_man_button: 2}", "{}"), "0.8 s", "0.4 s");
  const fs::path held = file(text);
  for (const std::string& said : {refusal(held), refusal_of([&] { execute(planned(held), {.keeps_tables = true}); })}) {
    // 2000 N/m (50 g / 100 g)^0.5 = 1414 N/m.
    says_like(said, R"(study\.yaml:11:\d+: nodes\.protocol\.conditions\.B: select\.use=fourth; coupling\.k_0=2 N/mm: )"
                    R"(.*k_device holds it at 1000)");
  }
  // With the limit out of the way, in the same condition, it is felt.
  BOOST_TEST(refusal(file(replaced(replaced(text, "500 N/m", "500 N/m; coupling.k_device=1 N/mm"), "2 N/mm",
                                   "2 N/mm; coupling.k_device=2 N/mm"))) == "");
}

BOOST_FIXTURE_TEST_CASE(levels_that_a_limit_makes_alike_in_one_condition_are_refused, Fixture) {
  const auto with = [this](const std::string& a, const std::string& b) {
    return refusal_with({"level: coupling.k_0", "unit: N/m", "standard: 500", "procedure: constant",
                         "levels: [100, 700]", "conditions:", "  A: select.use=first; coupling.k_device=" + a,
                         "  B: select.use=fourth; coupling.k_device=" + b});
  };
  // At the tool's mass the coupling has 0.7071 k_0: 849 N/m at the largest level.
  BOOST_TEST(with("850 N/m", "900 N/m") == "");
  const std::string bad = with("900 N/m", "840 N/m");
  says_like(bad,
            R"(study\.yaml:12:\d+: nodes\.protocol\.conditions\.B: select\.use=fourth; coupling\.k_device=840 N/m; )"
            R"(coupling\.k_0=1200 N/m: .*k_device holds it at 840)");
  says_not(bad, "conditions.A:");
}

BOOST_FIXTURE_TEST_CASE(settings_that_one_order_of_the_conditions_cannot_make_are_refused, Fixture) {
  const auto conditions = [](const std::string& a, const std::string& b) {
    return std::vector<std::string>{"conditions:", "  A: " + a + "; coupling.k_0=300 N/m",
                                    "  B: " + b + "; coupling.k_0=800 N/m"};
  };
  const std::string low_min = "coupling.k_min=100 N/m", low_most = "coupling.k_device=300 N/m";
  const std::string low = low_min + "; " + low_most, high = "coupling.k_device=600 N/m; coupling.k_min=500 N/m";
  BOOST_TEST(refusal_with(conditions(low, high)) == "");
  // From B to A: its k_device would be below the k_min of B, which still holds.
  std::string bad = refusal_with(conditions(low_most + "; " + low_min, high));
  says_like(bad,
            R"(study\.yaml:6:\d+: nodes\.protocol\.conditions\.A: .*k_min \(500\.0+\) is above k_device \(300\.0+\).*)"
            R"(coupling\.k_device=300 N/m is set after conditions\.B, .*another order)");
  says_not(bad, "conditions.B: coupling");
  // From A to B.
  bad = refusal_with(conditions(low, "coupling.k_min=500 N/m; coupling.k_device=600 N/m"));
  says_like(
      bad,
      R"(study\.yaml:7:\d+: nodes\.protocol\.conditions\.B: .*coupling\.k_min=500 N/m is set after conditions\.A)");
  // What no order makes is refused as it is.
  bad = refusal_with(conditions(low, "coupling.k_device=600 N/m; coupling.k_min=700 N/m"));
  BOOST_TEST(bad != "");
  says_not(bad, "another order");
  // And what is said to work does, whichever condition comes first.
  const fs::path works = with_protocol(conditions(low, high));
  std::set<std::string> begun;
  for (const std::string participant : {"P01", "P02"}) {
    run(study(participant, brief + Over{"protocol.procedure=constant", "protocol.levels=[0.25]", "protocol.repeats=2"},
              works),
        {}, {.keeps_tables = true});
    begun.insert(rows_of(table(participant)).at(0).at("condition"));
  }
  BOOST_TEST((begun == std::set<std::string>{"A", "B"}));
}

BOOST_FIXTURE_TEST_CASE(a_limit_that_is_noted_in_the_graph_is_refused_where_the_value_it_holds_is_set, Fixture) {
  const std::string stiff = "  coupling: {k_0: 2 N/mm}\n";
  // 2 N/mm asks for 1414 N/m, which k_device holds at 1000: as 1.5 N/mm would be, which asks for 1061.
  const std::string bad = refusal_with({"conditions:", "  A: coupling.k_0=2 N/mm", "  B: coupling.k_0=1 N/mm"}, stiff);
  says_like(bad,
            R"(study\.yaml:7:\d+: nodes\.protocol\.conditions\.A: coupling\.k_0=2 N/mm: .*k_device holds it at 1000)");
  says_not(bad, "conditions.B:");
  // The limit itself is felt as it is set.
  BOOST_TEST(refusal_with({"conditions:", "  A: coupling.k_device=0.8 N/mm", "  B: coupling.k_device=1 N/mm"}, stiff) ==
             "");
  // And what is neither, and asks for more than the limit.
  says_like(refusal_with({"conditions:", "  A: coupling.m_0=1 g", "  B: coupling.m_0=100 g"}),
            R"(conditions\.A: coupling\.m_0=1 g: .*k_device holds it at 1000)");
}

BOOST_AUTO_TEST_SUITE_END()
