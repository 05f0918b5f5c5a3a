// What a study runs, and what it makes of the metrics, worked out by hand.
#include "app/study/table/study.hpp"

#include "app/study/report/text_tables.hpp"
#include "app/study/table/study_csv.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/study/report/compare_report.hpp"
#include "app/study/report/study_report.hpp"
#include "app/study/report/work_precision.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(study_test)

using namespace tactor;

namespace {

constexpr std::size_t wide = 1000;  // columns, so that nothing is folded

struct StudyFile {
  TemporaryFolder folder;

  StudyFile() {
    for (const char* name : {"a.yaml", "b.yaml", "hold.yaml", "line.yaml"}) write(name, "");
    std::filesystem::create_directory(folder.path() / "more");
    write("more/a.yaml", "");
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder.path() / name) << text; }
  [[nodiscard]] StudySpec load(const std::string& text) const {
    write("study.yaml", text);
    return load_study(folder.path() / "study.yaml");
  }
  [[nodiscard]] std::string error(const std::string& text) const {
    try {
      static_cast<void>(load(text));
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
};

// Errors of two graphs by two configurations over two seeds: the second configuration errs half and a quarter as much
// in the first graph, four times and twice in the second.
Comparison comparison() {
  Comparison c;
  c.seeds = {7, 8};
  c.columns = {{"delivered.force.rms_error_N", "error"}, {"one_step.force.rms_error_N", "one step"}};
  const auto row = [&](const char* graph, std::size_t against, std::vector<double> delivered,
                       std::vector<double> next) {
    CompareRow one;
    one.graph = graph;
    one.configuration = "s";
    one.against = against;
    one.runs.resize(2);
    one.values = {std::move(delivered), std::move(next)};
    one.status.assign(2, RunStatus::done);
    one.message.assign(2, "");
    one.spread.assign(2, std::numeric_limits<double>::quiet_NaN());
    one.control_us.assign(2, 1000);
    c.rows.push_back(std::move(one));
  };
  row("a", 0, {0.2, 0.4}, {1, 1});
  row("a", 0, {0.1, 0.1}, {0, 1});
  row("b", 2, {1.0, 1.0}, {1, 1});
  row("b", 2, {4.0, 2.0}, {1, 1});
  return c;
}

/// What is laid over a graph, in its order: the names of files, and assignments.
std::vector<std::string> texts(const Overrides& overrides) {
  std::vector<std::string> found;
  for (const Patch& patch : overrides) {
    const Assignment* assignment = patch.assignment();
    found.push_back(assignment != nullptr     ? assignment->path + "=" + assignment->value
                    : patch.file() != nullptr ? patch.file()->filename().string()
                                              : "a map");
  }
  return found;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_study_runs_every_graph_by_every_combination) {
  const StudyFile file;
  const StudySpec spec = file.load(
      "title: t\ngraphs: [a.yaml, b.yaml]\nmethods: [hold.yaml, line.yaml]\nset: {x.p: 3 mm}\n"
      "vary:\n  'x.q, y.q': [1, '2']\n  x.r: [[1, 2], ~]\nseeds: 3\nfirst_seed: 5\n");
  BOOST_TEST(spec.name == "study");
  BOOST_TEST(spec.seeds == 3);
  BOOST_TEST(spec.first_seed == 5U);
  const std::vector<RunCase> cases = study_cases(spec, {set_patch("x.p=4 mm")});
  BOOST_REQUIRE(cases.size() == 2U * 2U * 2U * 2U);
  BOOST_TEST(cases[0].graph.filename() == "a.yaml");
  BOOST_TEST(cases[8].graph.filename() == "b.yaml");
  BOOST_TEST(cases[7].against == 3U);
  BOOST_TEST(cases[8].against == 8U);
  // The last axis goes fastest, methods slowest; the command line comes last, so that it wins.
  const RunCase& c = cases[8 + 4 + 2 + 0];
  const std::vector<std::string> expected{"line.yaml", "x.p=3 mm", "x.q='2'", "y.q='2'", "x.r=[1, 2]", "x.p=4 mm"};
  BOOST_TEST(texts(c.overrides) == expected, boost::test_tools::per_element());
  const std::vector<std::string> unvaried{"line.yaml", "x.p=3 mm", "x.p=4 mm"};
  BOOST_TEST(texts(c.unvaried) == unvaried, boost::test_tools::per_element());
  // A value of the study is at its place there, one of the command line at its option.
  BOOST_TEST(c.overrides[1].place.text().ends_with("study.yaml:4:7"), c.overrides[1].place.text());
  BOOST_TEST(c.overrides[4].place.text().ends_with("study.yaml:7:9"), c.overrides[4].place.text());
  BOOST_TEST(c.overrides[5].place.text() == "--set x.p=4 mm");
  BOOST_TEST(c.configuration == "line x.q, y.q='2' x.r=[1, 2]");
}

BOOST_AUTO_TEST_CASE(without_methods_and_values_the_graphs_run_as_they_are) {
  const StudyFile file;
  const std::vector<RunCase> cases = study_cases(file.load("graphs: [a.yaml]\n"), {});
  BOOST_REQUIRE(cases.size() == 1U);
  BOOST_TEST(cases[0].overrides.empty());
}

BOOST_AUTO_TEST_CASE(a_bad_study_is_refused_with_every_place) {
  const StudyFile file;
  BOOST_TEST(
      file.error("graphs: [a.yaml, c.yaml]\n").find("study.yaml:1:18: graphs: expected a graph file that exists") !=
      std::string::npos);
  BOOST_TEST(file.error("graphs: [a.yaml, more/a.yaml]\n").find("1:18: graphs: expected files of different names") !=
             std::string::npos);
  BOOST_TEST(file.error("title: x\n").find("expected the key graphs") != std::string::npos);
  BOOST_TEST(file.error("graphs: [a.yaml]\ntiming: {repeats: 100}\n").empty());
  const std::string repeats = file.error("graphs: [a.yaml]\ntiming: {repeats: 101}\n");
  BOOST_TEST(repeats.find("study.yaml:2:19: timing.repeats: expected") != std::string::npos, repeats);
  const std::string all = file.error("graphs: a.yaml\nvary: {x.p: 3}\nseeds: 0\nseed: 1\nset: [1]\nmethods: []\n");
  for (const char* text :
       {"1:9: graphs: expected a list", "2:13: vary.x.p: expected a list of values", "3:8: seeds: expected", "4:1",
        "5:6: set: expected a map", "6:10: methods: expected a list"}) {
    BOOST_TEST(all.find(text) != std::string::npos, text << " in " << all);
  }
}

BOOST_AUTO_TEST_CASE(values_that_would_replace_each_other_are_refused_with_every_place) {
  const StudyFile file;
  const std::string all = file.error(
      "graphs: [a.yaml]\nset: {x.p: 1}\nvary:\n  x.p: [1, 2]\n  'x.q, y.q': [3]\n  y.q: [4]\n  x.r: [5, 6, 5]\n");
  for (const char* text : {"4:8: vary.x.p: named twice", "6:8: vary.y.q: named twice",
                           "7:15: vary.x.r: expected different values, found 5 again"}) {
    BOOST_TEST(all.find(text) != std::string::npos, text << " in " << all);
  }
  BOOST_TEST(file.error("graphs: [a.yaml]\nset: {'x.p, x.p': 1}\n").find("2:19: set.x.p: named twice") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(the_command_line_lies_over_the_methods_and_may_not_set_what_is_varied) {
  const StudyFile file;
  const StudySpec spec = file.load("graphs: [a.yaml]\nmethods: [hold.yaml]\nvary: {x.p: [1, 2]}\n");
  // In the order of the command line, after all that the study says.
  const std::vector<RunCase> cases = study_cases(spec, {set_patch("x.q=1"), over_patch("b.yaml")});
  const std::vector<std::string> expected{"hold.yaml", "x.p=2", "x.q=1", "b.yaml"};
  BOOST_TEST(texts(cases[1].overrides) == expected, boost::test_tools::per_element());
  const auto refusal = [&](const StudySpec& of, const Patch& patch) {
    try {
      study_cases(of, {set_patch("x.q=1"), patch});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  BOOST_TEST(refusal(spec, set_patch("x.p = 3")) ==
             "--set x.p = 3: the study varies x.p; take it out of the study's `vary` first");
  const StudySpec long_and_short = file.load("graphs: [a.yaml]\nvary: {duration: [1, 2]}\n");
  BOOST_TEST(refusal(long_and_short, option_patch("--duration", "duration", "3")) ==
             "--duration 3: the study varies duration; take it out of the study's `vary` first");
  BOOST_TEST(refusal(spec, set_patch("seed=3")) ==
             "--set seed=3: expected --first-seed and --seeds, which choose the seeds of these runs");
}

BOOST_AUTO_TEST_CASE(a_duration_of_the_command_line_comes_after_that_of_the_study) {
  const StudyFile file;
  const StudySpec spec = file.load("graphs: [a.yaml]\nduration: 300 ms\nreference: {set: {x.k: 9}}\n");
  const std::vector<RunCase> cases = study_cases(spec, {option_patch("--duration", "duration", "2")});
  const std::vector<std::string> expected{"duration=300 ms", "duration=2"};
  BOOST_TEST(texts(cases[0].overrides) == expected, boost::test_tools::per_element());
  // What makes the reference another graph comes last.
  const std::vector<std::string> reference{"duration=300 ms", "duration=2", "x.k=9"};
  BOOST_TEST(texts(cases[0].reference.value()) == reference, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(every_row_is_judged_against_the_same_cell_of_all_other_axes) {
  const StudyFile file;
  const auto against = [&](const std::string& more) {
    std::vector<std::size_t> rows;
    for (const RunCase& c : study_cases(file.load("graphs: [a.yaml, b.yaml]\n" + more), {})) rows.push_back(c.against);
    rows.resize(rows.size() / 2);  // the second graph has its own
    return rows;
  };
  const auto is = [](const std::vector<std::size_t>& found, const std::vector<std::size_t>& expected) {
    BOOST_TEST(found == expected, boost::test_tools::per_element());
  };
  const std::string methods = "methods: [hold.yaml, line.yaml]\nvary: {x.k: [1, 2, 3]}\n";
  is(against(methods), {0, 1, 2, 0, 1, 2});
  is(against(methods + "baseline: {method: line}\n"), {3, 4, 5, 3, 4, 5});
  is(against(methods + "baseline: {x.k: 2}\n"), {1, 1, 1, 4, 4, 4});
  is(against(methods + "baseline: {method: hold, x.k: 3}\n"), {2, 2, 2, 2, 2, 2});
  // Without methods: along the first axis.
  is(against("vary: {x.p: [1, 2], x.q: [3, 4]}\n"), {0, 1, 0, 1});
  is(against("vary: {x.p: [1, 2], x.q: [3, 4]}\nbaseline: {x.q: 4}\n"), {1, 1, 3, 3});
  is(against("vary: {x.p: [1, 2], x.q: [3, 4]}\ndesign: one_at_a_time\n"), {0, 0, 0});
  // Draws have counterparts among the methods alone.
  is(against("vary: {x.p: {from: 1, to: 2, count: 2}}\ndesign: {latin_hypercube: {samples: 3}}\n"), {0, 1, 2});
  is(against("methods: [hold.yaml, line.yaml]\nvary: {x.p: {from: 1, to: 2, count: 2}}\n"
             "design: {latin_hypercube: {samples: 2}}\n"),
     {0, 1, 0, 1});
}

BOOST_AUTO_TEST_CASE(a_ratio_of_a_cell_is_to_the_baseline_of_that_cell) {
  const StudyFile file;
  const StudySpec spec =
      file.load("graphs: [a.yaml]\nmethods: [hold.yaml, line.yaml]\nvary: {x.k: [1, 2]}\nseeds: 3\n");
  Comparison c;
  c.seeds = {1, 2, 3};
  c.columns = {{"delivered.force.rms_error_N", "error"}};
  for (const RunCase& one : study_cases(spec, {})) {
    CompareRow row;
    row.graph = "a";
    row.configuration = one.configuration;
    row.against = one.against;
    row.runs.resize(3);
    row.status.assign(3, RunStatus::done);
    row.message.assign(3, "");
    row.spread.assign(3, std::numeric_limits<double>::quiet_NaN());
    row.control_us.assign(3, 1000);
    // Eight times the stiffness, eight times the error; the line halves it at either.
    const double error = (one.configuration.find("x.k=2") != std::string::npos ? 8.0 : 1.0) *
                         (one.configuration.starts_with("line") ? 0.5 : 1.0);
    row.values = {{error, 2 * error, 3 * error}};
    c.rows.push_back(std::move(row));
  }
  const Study study = make_study(spec, std::move(c));
  BOOST_REQUIRE(study.ratios.size() == 4U);
  for (const auto& [row, ratio] : std::map<std::size_t, double>{{0, 1}, {1, 1}, {2, 0.5}, {3, 0.5}}) {
    BOOST_TEST(std::abs(study.ratios[row].delivered->ratio - ratio) < 1e-12);
  }
  BOOST_TEST(study_table(study, 200).find("ratios are to method hold with the same x.k\n") != std::string::npos);
  const nlohmann::ordered_json json = to_json(study);
  BOOST_TEST(json["baseline"]["method"] == "hold");
  BOOST_TEST(json["rows"][3]["against"]["row"] == "a hold x.k=2");
}

BOOST_AUTO_TEST_CASE(a_baseline_that_is_no_cell_of_the_study_is_refused_with_its_place) {
  const StudyFile file;
  const std::string study = "graphs: [a.yaml]\nmethods: [hold.yaml, line.yaml]\nvary: {x.k: [1, 2]}\n";
  const auto refused = [&](const std::string& more, const std::string& text) {
    const std::string found = file.error(study + more);
    BOOST_TEST(found.find(text) != std::string::npos, text << " in " << found);
  };
  refused("baseline: {metod: hold}\n",
          "baseline.metod: expected an axis of the study (method, x.k), found metod; did you mean \"method\"?");
  refused("baseline: {method: spline}\n",
          "study.yaml:4:20: baseline.method: expected one of the values of this axis (hold, line), found");
  refused("baseline: hold\n", "4:11: baseline: expected a map of an axis");
  refused("baseline: {}\n", "4:11: baseline: expected an axis of the study");
  refused("baseline: {x.k: 2}\ndesign: one_at_a_time\n", "baseline.x.k: expected the first value of the axis, 1");
  refused("baseline: {x.k: 1}\ndesign: {latin_hypercube: {samples: 2}}\n", "baseline.x.k: expected method");
}

BOOST_AUTO_TEST_CASE(ratios_are_geometric_means_over_seeds_and_over_graphs) {
  StudySpec spec;
  spec.graphs = {"a.yaml", "b.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  const Study study = make_study(spec, comparison());
  BOOST_REQUIRE(study.ratios.size() == 4U);
  BOOST_TEST(study.ratios[0].delivered->ratio == 1.0);
  // 1/2 and 1/4: sqrt(1/8); 4 and 2: sqrt(8).
  BOOST_TEST(std::abs(study.ratios[1].delivered->ratio - std::sqrt(0.125)) < 1e-12);
  BOOST_TEST(std::abs(study.ratios[3].delivered->ratio - std::sqrt(8.0)) < 1e-12);
  // Over the graphs: sqrt(1/2 * 4) with the first seed, sqrt(1/4 * 2) with the second.
  const GeometricMean over = *study.ratios_over_graphs[1].delivered;
  BOOST_TEST(std::abs(over.ratio - 1) < 1e-12);
  BOOST_TEST(std::isnan(over.high));  // two seeds are too few for an interval
  // A ratio to or from nothing is none.
  BOOST_TEST(!study.ratios[1].one_step);
  BOOST_TEST(!study.ratios_over_graphs[1].one_step);
  BOOST_TEST(study.ratios[3].one_step->ratio == 1.0);
}

BOOST_AUTO_TEST_CASE(the_table_file_has_a_line_a_run_with_its_values_quoted_where_needed) {
  StudySpec spec;
  spec.graphs = {"a.yaml", "b.yaml"};
  spec.vary = {{"x.p, y.p", {"x.p", "y.p"}, {{"[1, 2]", {}, {}}, {"3", {}, {}}}, {}}};
  Comparison metrics = comparison();
  metrics.columns[1].run_time = true;
  metrics.rows[3].values[0][1] = std::numeric_limits<double>::quiet_NaN();
  metrics.rows[3].status[1] = RunStatus::failed;
  const Study study = make_study(spec, metrics);
  BOOST_TEST(study_csv(study) ==
             "graph,method,\"x.p, y.p\",seed,status,delivered.force.rms_error_N\n"
             "a,,\"[1, 2]\",7,done,0.2\na,,\"[1, 2]\",8,done,0.4\na,,3,7,done,0.1\na,,3,8,done,0.1\n"
             "b,,\"[1, 2]\",7,done,1\nb,,\"[1, 2]\",8,done,1\nb,,3,7,done,4\nb,,3,8,failed,\n");
  BOOST_TEST(run_times_csv(study).find("seed,one_step.force.rms_error_N,spread_of_repeats,control_us\n"
                                       "a,,\"[1, 2]\",7,1,,1000\n") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(run_times_that_spread_by_more_than_a_tenth_are_warned_of) {
  StudySpec spec;
  spec.graphs = {"a.yaml", "b.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  spec.repeats = 3;
  Comparison metrics = comparison();
  for (CompareRow& row : metrics.rows) row.spread.assign(2, 0.02);
  BOOST_TEST(timing_note(make_study(spec, metrics)).warning.empty());
  for (CompareRow& row : metrics.rows) row.spread.assign(2, 0.3);
  BOOST_TEST(timing_note(make_study(spec, metrics)).warning.find("30 %") != std::string::npos);
  // One run of eight is enough, whatever the median is: the row is named, with how far and how many.
  for (CompareRow& row : metrics.rows) row.spread.assign(2, 0.02);
  metrics.rows[3].spread[1] = 0.42;
  const TimingNote one = timing_note(make_study(spec, metrics));
  BOOST_TEST(one.spread_median == 0.02);
  BOOST_TEST(one.spread_worst == 0.42);
  BOOST_TEST(one.text.find("2.0 % in the median and 42.0 % at most") != std::string::npos, one.text);
  BOOST_TEST(
      one.warning.find("the repeats of 1 of 8 runs spread by more than 10 %: b s (by 42 % at most, in 1 of 2)") !=
          std::string::npos,
      one.warning);
  // The worst come first and the rest are counted.
  for (std::size_t row = 0; row < 4; ++row) metrics.rows[row].graph = std::string(1, static_cast<char>('k' + row));
  for (std::size_t row = 0; row < 4; ++row) metrics.rows[row].spread[0] = 0.15 + 0.1 * static_cast<double>(row);
  const std::string all = timing_note(make_study(spec, metrics)).warning;
  BOOST_TEST(all.find("the repeats of 5 of 8 runs spread by more than 10 %: n s (by 45 % at most, in 2 of 2), m s (by "
                      "35 % at most, in 1 of 2), l s (by 25 % at most, in 1 of 2) and 1 more") != std::string::npos,
             all);
  for (CompareRow& row : metrics.rows) row.spread.assign(2, 0.02);
  for (std::size_t row = 0; row < 4; ++row) metrics.rows[row].control_us = {1000, row < 2 ? 1000 : 1500.0};
  const TimingNote note = timing_note(make_study(spec, metrics));
  BOOST_TEST(note.control_us == 1000);
  BOOST_TEST(note.control_spread == 0.5);
  BOOST_TEST(note.warning.find("the fixed computation spread by 50 %") != std::string::npos, note.warning);
}

BOOST_AUTO_TEST_CASE(what_is_said_of_run_times_tells_repeats_from_single_runs) {
  StudySpec spec;
  spec.graphs = {"a.yaml", "b.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  const std::string single = timing_note(make_study(spec, comparison())).text;
  BOOST_TEST(single.find("of a single run each; how far repeats would spread is unknown.") != std::string::npos,
             single);
  spec.warm_up = 2;
  const std::string warm = timing_note(make_study(spec, comparison())).text;
  BOOST_TEST(warm.find("of a single run each after 2 runs that did not count") != std::string::npos, warm);
}

BOOST_AUTO_TEST_CASE(a_failed_seed_leaves_the_figures_of_the_others_and_is_told_everywhere) {
  StudySpec spec;
  spec.graphs = {"a.yaml", "b.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  Comparison metrics = comparison();
  metrics.rows[3].values[0][0] = std::numeric_limits<double>::quiet_NaN();
  metrics.rows[3].status[0] = RunStatus::failed;
  metrics.rows[3].message[0] = "it broke";
  const Study study = make_study(spec, metrics);
  const CompareRow& row = study.comparison.rows[3];
  BOOST_TEST(row.name() == "b s (1 of 2 seeds)");
  BOOST_TEST(row.mean_of("delivered.force.rms_error_N", study.comparison.columns) == 2.0);
  // The ratio of the seed that both have, 2 to 1; over the graphs sqrt(1/4 * 2) of that seed alone.
  BOOST_TEST(study.ratios[3].delivered->count == 1U);
  BOOST_TEST(std::abs(study.ratios[3].delivered->ratio - 2) < 1e-12);
  BOOST_TEST(study.ratios_over_graphs[1].delivered->count == 1U);
  BOOST_TEST(std::abs(study.ratios_over_graphs[1].delivered->ratio - std::sqrt(0.5)) < 1e-12);
  const std::string table = study_table(study, wide);
  BOOST_TEST(table.find("line (1 of 2 seeds)") != std::string::npos, table);
  BOOST_TEST(table.find("line (seeds missing)") != std::string::npos, table);
  BOOST_TEST(failures_text(study.comparison) == "b s, seed 7: it broke\n");
  const nlohmann::ordered_json json = to_json(study)["rows"][3];
  BOOST_TEST(json["seeds_done"] == 1);
  BOOST_TEST(json["status"].dump() == R"(["failed","done"])");
  BOOST_TEST(json["failures"].dump() == R"([{"seed":7,"message":"it broke"}])");
  BOOST_TEST(json["metrics"]["delivered.force.rms_error_N"]["mean"] == 2.0);
  // With no seed left there is no metric, and no crash.
  metrics.rows[3].status[1] = RunStatus::failed;
  metrics.rows[3].values[0][1] = std::numeric_limits<double>::quiet_NaN();
  const Study none = make_study(spec, metrics);
  BOOST_TEST(!none.ratios[3].delivered);
  BOOST_TEST(!none.ratios_over_graphs[1].delivered);
  BOOST_TEST(study_table(none, wide).find("line (0 of 2 seeds)") != std::string::npos);
  // Where nothing is done nothing is said of run times, and no line is left empty for it.
  for (CompareRow& one : metrics.rows) one.status.assign(2, RunStatus::failed);
  const Study nothing = make_study(spec, metrics);
  BOOST_TEST(timing_note(nothing).text.empty());
  for (const std::string& text :
       {study_table(nothing, wide), work_precision_table(nothing, work_precision(nothing), wide),
        comparison_table(nothing.comparison, timing_note(nothing), wide)}) {
    BOOST_TEST(text.find("\n\n\n") == std::string::npos, text);
    BOOST_TEST(text.find("\n  \n") == std::string::npos, text);
    BOOST_TEST(!text.ends_with("\n\n"), text);
  }
  BOOST_TEST(study_report(nothing).find("<p></p>") == std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_ratio_to_a_first_line_that_lacks_seeds_tells_over_how_many_it_is) {
  StudySpec spec;
  spec.graphs = {"a.yaml", "b.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  Comparison metrics = comparison();
  metrics.rows[2].values[0][0] = std::numeric_limits<double>::quiet_NaN();
  metrics.rows[2].status[0] = RunStatus::failed;
  metrics.rows[2].message[0] = "it broke";
  const Study study = make_study(spec, metrics);
  BOOST_TEST(study.comparison.rows[3].seeds_text().empty());
  // The line itself lacks nothing, but its ratio is that of the second seed, 2 to 1, and one value has no interval.
  const std::string table = study_table(study, wide);
  const std::string page = study_report(study);
  for (const std::string& text : {table, page}) {
    BOOST_TEST(text.find("2.000 [-] over 1 seed") != std::string::npos, text);
    // Over the graphs sqrt(1/4 * 2) of that seed.
    BOOST_TEST(text.find("0.707 [-] over 1 seed") != std::string::npos, text);
    // The first graph has all, sqrt(1/8), and says nothing of it.
    BOOST_TEST(text.find("0.354 [-]") != std::string::npos, text);
    BOOST_TEST(text.find("] over 2 seeds") == std::string::npos, text);
  }
  BOOST_TEST(table.find("line (seeds missing)") != std::string::npos, table);
  BOOST_TEST(study.incomplete(1) == " (seeds missing)");
  const nlohmann::ordered_json json = to_json(study);
  for (const auto& one : {json["rows"][3]["against"]["ratio"], json["configurations"][1]["over_graphs"]}) {
    BOOST_TEST(one["delivered_rms"]["count"] == 1);
    BOOST_TEST(one["delivered_rms"]["seeds"] == 2);
    BOOST_TEST(one["delivered_rms"]["low"].is_null());
    BOOST_TEST(one["delivered_rms"]["high"].is_null());
  }
  BOOST_TEST(json["rows"][1]["against"]["ratio"]["delivered_rms"]["low"].is_null());
}

namespace {

/// Two rows of so many seeds, whose errors are those of the two functions, by seed.
Comparison two_rows(std::size_t seeds, double (*first)(std::size_t), double (*second)(std::size_t),
                    const std::string& too_coarse = {}) {
  std::vector<RunRecord> records(2 * seeds);
  std::vector<std::uint64_t> numbers;
  for (std::size_t s = 0; s < seeds; ++s) numbers.push_back(s);
  for (std::size_t r = 0; r < records.size(); ++r) {
    records[r].number = r;
    RunResult& result = records[r].result;
    const double error = r < seeds ? first(r) : second(r - seeds);
    result.metrics = {{"one_step.force.rms_error_N", error}};
    if (too_coarse.empty()) result.metrics.emplace_back("delivered.force.rms_error_N", error);
    result.series = {{"one_step_error", "N", {0, 1}, {error, error + 1}}};
    result.reference.too_coarse = too_coarse;
  }
  return make_comparison({{"a.yaml", {}, {}, 0, {}}, {"b.yaml", {}, {}, 0, {}}}, numbers, records, {},
                         {{"delivered.force.rms_error_N", {"delivered.force.rms_error_N", "N", "", Better::lower}}});
}

std::string page_of(const Comparison& comparison) {
  return compare_report(comparison, timing_note(comparison, Repeats{1, 0}), "");
}

}  // namespace

BOOST_AUTO_TEST_CASE(seeds_whose_runs_are_identical_are_said_to_be_so_and_tell_a_mean_alone) {
  const Comparison found = two_rows(
      6, [](std::size_t) { return 0.1; }, [](std::size_t) { return 0.1717; });
  const std::string judged = judged_text(found);
  BOOST_TEST(judged ==
             "  b: one-step +0.0717 N, the 6 seeds are identical: not tested; delivered +0.0717 N, the 6 seeds "
             "are identical: not tested\n");
  const std::string page = page_of(found);
  for (const std::string& text : {page, comparison_table(found, timing_note(found, Repeats{1, 0}), wide)}) {
    BOOST_TEST(text.find("the runs of all seeds are identical in each row") != std::string::npos, text);
    BOOST_TEST(text.find("the 6 seeds are identical: not tested") != std::string::npos, text);
  }
  BOOST_TEST(page.find("The runs of all 6 seeds are identical, so it is unknown") != std::string::npos, page);
  const nlohmann::ordered_json against = to_json(found)["graphs"][1]["against"];
  BOOST_TEST(!against.contains("one_step_anova"));
  BOOST_TEST(against["delivered_rms"]["identical"] == "seeds");
  for (const char* name : {"low_N", "high_N", "effect_size", "p_wilcoxon"})
    BOOST_TEST(against["delivered_rms"][name].is_null());
  StudySpec spec;
  spec.graphs = {"a.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  BOOST_TEST(study_table(make_study(spec, found), wide).find("1.717 [-]") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(rows_that_are_the_same_in_every_seed_are_said_to_be_so) {
  const auto varies = [](std::size_t seed) { return 1.0 + static_cast<double>(seed); };
  const Comparison found = two_rows(7, varies, varies);
  BOOST_TEST(!found.rows[0].identical_seeds);
  BOOST_TEST(judged_text(found).find("delivered the same in each of 7 seeds\n") != std::string::npos,
             judged_text(found));
  BOOST_TEST(judged_text(found).find("ANOVA F = 0, p = 1;") != std::string::npos, judged_text(found));
  BOOST_TEST(page_of(found).find("No method is nearer to the reference than the others") != std::string::npos);
  BOOST_TEST(to_json(found)["graphs"][1]["against"]["delivered_rms"]["identical"] == "rows");
}

BOOST_AUTO_TEST_CASE(rows_without_a_truth_that_is_finer_than_their_runs_are_not_ranked_and_say_why) {
  const std::string why = "the reference run is no finer than the run: node dynamics steps at 60 Hz in both";
  const auto varies = [](std::size_t seed) { return 1.0 + static_cast<double>(seed); };
  const Comparison found = two_rows(
      7, varies, [](std::size_t seed) { return 3.0 - 0.1 * static_cast<double>(seed); }, why);
  const std::string judged = judged_text(found);
  BOOST_TEST(
      judged.starts_with("  b: delivered not compared, the reference is no finer than the run; one-step ANOVA F"),
      judged);
  BOOST_TEST(judged.find("; one-step -1.3000 N") != std::string::npos, judged);
  const std::string page = page_of(found);
  BOOST_TEST(page.find("No method is ranked.<br>\nNot ranked, because " + why + ": ") != std::string::npos, page);
  BOOST_TEST(page.find("aria-label=\"best\"") == std::string::npos);
  StudySpec spec;
  spec.graphs = {"a.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  const Study study = make_study(spec, found);
  for (const ErrorRatio& ratio : study.ratios) {
    BOOST_TEST(!ratio.delivered);
    BOOST_TEST(ratio.one_step.has_value());
  }
  for (const std::string& text :
       {page, study_report(study), comparison_table(found, timing_note(found, Repeats{1, 0}), wide)}) {
    BOOST_TEST(text.find("nothing is ranked: " + why) != std::string::npos, text);
  }
  const nlohmann::ordered_json json = to_json(found)["graphs"][1];
  BOOST_TEST(json["reference_too_coarse"] == why);
  BOOST_TEST(json["against"]["delivered_rms"].is_null());
  // A prediction is compared with the result that came, which needs no reference.
  BOOST_TEST(json["against"]["one_step_rms"]["pairs"] == 7);
  // One such row among others is left out of the ranking alone.
  Comparison mixed = two_rows(7, varies, [](std::size_t seed) { return 9.0 + static_cast<double>(seed * seed); });
  mixed.rows.push_back(found.rows[1]);
  mixed.rows.back().values = mixed.rows[1].values;
  const std::string verdict = page_of(mixed);
  BOOST_TEST(verdict.find("nearest to the reference") != std::string::npos, verdict);
  BOOST_TEST(verdict.find("1 of 3 rows are not ranked") != std::string::npos, verdict);
}

BOOST_AUTO_TEST_CASE(rows_are_judged_over_the_seeds_that_both_have) {
  constexpr std::size_t seeds = 7, lacking = 1;
  std::vector<RunRecord> records(2 * seeds);
  const auto fill = [&](std::size_t number, double error) {
    records[number].number = number;
    records[number].result.metrics = {{"delivered.force.rms_error_N", error}};
    records[number].result.series = {{"one_step_error", "N", {0, 1}, {error, error + 1}}};
  };
  // The first row errs 1, 2, ... 7 N by seed, the second 1 N more with even ones and 2 N more with odd ones.
  for (std::size_t s = 0; s < seeds; ++s) {
    const double error = 1.0 + static_cast<double>(s);
    fill(s, error);
    fill(seeds + s, error + (s % 2 == 0 ? 1 : 2));
  }
  records[seeds + lacking] = {};
  records[seeds + lacking].number = seeds + lacking;
  records[seeds + lacking].status = RunStatus::failed;
  records[seeds + lacking].message = "it broke";
  const Comparison found =
      make_comparison({{"a.yaml", {}, {}, 0, {}}, {"b.yaml", {}, {}, 0, {}}}, {1, 2, 3, 4, 5, 6, 7}, records);
  BOOST_REQUIRE(found.rows[1].delivered.has_value());
  BOOST_TEST(found.rows[1].delivered->pairs == 6U);
  BOOST_TEST(std::abs(found.rows[1].delivered->mean - 4.0 / 3) < 1e-12);
  BOOST_TEST(judged_text(found).find("b (6 of 7 seeds): ") == 2U, judged_text(found));
  // By scipy's f_oneway.
  BOOST_TEST(judged_text(found).find("ANOVA F = 2.19, p = 0.153 over 6 seeds; ") != std::string::npos,
             judged_text(found));
  StudySpec spec;
  spec.graphs = {"a.yaml"};
  spec.methods = {{"hold", "hold.yaml", {}}, {"line", "line.yaml", {}}};
  // 4/3 -+ t(0.975, 5) sd / sqrt(6) = 2.570582 sqrt(4/15 / 6).
  const std::string page = study_report(make_study(spec, found));
  BOOST_TEST(page.find(">2.19 over 6 seeds</td>") != std::string::npos, page);
  BOOST_TEST(page.find(">[+0.7914, +1.8753] over 6 seeds</td>") != std::string::npos, page);
  const std::string table = comparison_table(found, timing_note(found, Repeats{1, 0}), wide);
  BOOST_TEST(table.find("6 of 7 seeds") != std::string::npos, table);
  BOOST_TEST(table.find("5.67") != std::string::npos, table);
}

BOOST_AUTO_TEST_SUITE_END()
