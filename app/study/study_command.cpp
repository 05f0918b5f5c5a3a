#include "app/study/study_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/report/html_page.hpp"
#include "app/report/scene_picture.hpp"
#include "app/study/finish_study.hpp"
#include "app/study/report/compare_report.hpp"
#include "app/study/report/stability_map.hpp"
#include "app/study/report/text_tables.hpp"
#include "app/study/run/run_cases.hpp"
#include "app/study/run/study_metrics.hpp"
#include "app/study/table/comparison.hpp"
#include "app/study/table/warnings.hpp"
#include "app/terminal.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Runs the cases with a bar on the terminal, telling each note once.
CasesOutcome run_watched(const std::vector<RunCase>& cases, Registry& registry, CasesOptions options) {
  ProgressBar bar;
  // Graphs that are compared share their bodies: what is said of one is not said again of the others, nor by the runs.
  options.note = once([&](const std::string& note) {
    bar.clear();
    tell_note(note);
  });
  options.cache_folder = default_cache_folder();
  options.interruptions = [] { return interruption.load(); };
  options.progress = [&](double share, const std::string& what) { bar.draw(share, what); };
  return run_cases(cases, registry, options);
}

/// Notes in each case in what more than its method differs from the first, and draws the scenes that differ.
std::string tell_scenes_apart(std::vector<RunCase>& cases, Registry& registry) {
  const auto graph_of = [&](const RunCase& c) { return load_graph(c.graph, registry, c.overrides); };
  const auto figure_of = [&](const GraphSpec& graph) {
    try {
      return scene_figure(drawn_scene(graph),
                          "The scene of " + breakable(graph_name(graph.file)) + " as the run begins.");
    } catch (const InputError& error) {
      return no_scene_figure(error);
    }
  };
  const GraphSpec first = graph_of(cases.front());
  std::string figures = figure_of(first);
  for (std::size_t i = 1; i < cases.size(); ++i) {
    const GraphSpec graph = graph_of(cases[i]);
    cases[i].unlike = difference_beside_method(graph, first);
    if (!cases[i].unlike.empty()) figures += figure_of(graph);
  }
  return figures;
}

}  // namespace

int run_study(const StudyRequest& request) {
  PreparedStudy study = prepare_study(request);
  CasesOptions options;
  static_cast<CasesSettings&>(options) = study.settings;
  options.reference_jobs = request.jobs;
  options.jobs = request.jobs;
  options.table = study.folder / "study.sqlite";
  options.mode = request.resume ? TableMode::resume : request.overwrite ? TableMode::overwrite : TableMode::create;
  Registry registry(default_node_folders());
  options.planned = [&](const RunMetrics& metrics) {
    check_metrics(study.spec, metrics, registry);
    if (request.before_runs) request.before_runs();
  };
  if (study.spec.report == StudyReport::stability && !study.spec.record.empty()) {
    check_record(study.spec, study.cases, registry);
  }
  CasesOutcome outcome = run_watched(study.cases, registry, options);
  const std::string interrupted =
      fmt::format("interrupted: {} of {} runs are kept in {}; the same command with --resume continues",
                  outcome.records.size(), study.cases.size() * options.seeds.size(), options.table.string());
  if (outcome.interrupted) throw RunError(interrupted);
  return finish_study(
      study.spec, std::move(study.cases), std::move(outcome), registry,
      {.folder = study.folder, .seeds = options.seeds, .jobs = request.jobs, .interrupted = interrupted});
}

int run_compare(const CompareRequest& request) {
  refuse_seed(request.overrides);
  std::vector<RunCase> cases;
  for (const ComparedGraph& graph : request.graphs) {
    Overrides overrides = graph.method;
    overrides.insert(overrides.end(), request.overrides.begin(), request.overrides.end());
    cases.push_back({.graph = graph.file, .overrides = std::move(overrides), .configuration = graph.method_name});
  }
  CasesOptions options;
  options.seeds = seeds_from(request.first_seed, request.seeds);
  options.reference_jobs = request.jobs;
  const Repeats repeats = warmed_up(request.repeats);
  options.repeats = repeats.count;
  options.warm_up = repeats.warm_up;
  options.curves = true;
  options.judge_warm = request.judge == JudgedPart::warm;
  options.table = request.out / "compare.sqlite";
  options.mode = TableMode::overwrite;
  options.identity.title = "compare";
  Registry registry(default_node_folders());
  CasesOutcome outcome = run_watched(cases, registry, options);
  if (outcome.interrupted) throw RunError("interrupted");
  for (RunCase& c : cases) c.judged = outcome.judged[c.group];
  const std::string scenes = tell_scenes_apart(cases, registry);
  Comparison comparison =
      make_comparison(cases, options.seeds, std::move(outcome.records), {}, std::move(outcome.declared));
  comparison.provenance = outcome.provenance;
  const TimingNote timing = timing_note(comparison, repeats);
  fmt::print("{}\n", request.brief ? brief_table(comparison, timing, terminal_columns())
                                   : comparison_table(comparison, timing, terminal_columns()));
  // A file that cannot be written leaves the table.
  std::fflush(stdout);
  nlohmann::ordered_json json = to_json(comparison);
  json["timing"] = to_json(timing);
  write_file(request.out / "compare.json", json.dump(2) + "\n");
  write_file(request.out / "report.html", compare_report(comparison, timing, scenes));
  fmt::print("  {}\n", (request.out / "report.html").string());
  const int code = told_failures(comparison);
  const bool refused = std::any_of(comparison.rows.begin(), comparison.rows.end(), [](const CompareRow& row) {
    return std::find(row.status.begin(), row.status.end(), RunStatus::refused) != row.status.end();
  });
  return refused ? 2 : code;
}

}  // namespace tactor
