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
#include "app/results_folder.hpp"
#include "app/study/report/stability_map.hpp"
#include "app/study/report/study_report.hpp"
#include "app/study/report/text_tables.hpp"
#include "app/study/report/work_precision.hpp"
#include "app/study/run/bytes.hpp"
#include "app/study/run/run_cases.hpp"
#include "app/study/run/study_metrics.hpp"
#include "app/study/run/worker_pool.hpp"
#include "app/study/table/study.hpp"
#include "app/study/table/study_csv.hpp"
#include "app/study/table/study_export.hpp"
#include "app/study/table/warnings.hpp"
#include "app/terminal.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

std::vector<std::uint64_t> seeds_from(std::uint64_t first, std::int64_t count) {
  std::vector<std::uint64_t> seeds;
  for (std::int64_t s = 0; s < count; ++s) seeds.push_back(first + static_cast<std::uint64_t>(s));
  return seeds;
}

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

/// Everything that the command line lays over a study and that its results depend on.
std::string options_text(const StudyRequest& request, const StudySpec& spec) {
  std::string text = fmt::format("seeds {} from {}; short {}", spec.seeds, spec.first_seed, request.is_short);
  for (const Patch& patch : request.overrides) {
    const fs::path* over = patch.file();
    text += "\n" + (over == nullptr ? patch.place.file : "--over " + fs::absolute(*over).string());
  }
  return content_key({text});
}

/// What the runner spent, for bench/study_overhead.py.
nlohmann::ordered_json to_json(const CasesOutcome& outcome) {
  return {{"runs", outcome.records.size() - outcome.found},
          {"runs_found", outcome.found},
          {"crashes", outcome.crashes},
          {"total_cpu_s", outcome.cost.total_cpu_s},
          {"run_cpu_s", outcome.cost.run_cpu_s},
          {"reference_cpu_s", outcome.cost.reference_cpu_s},
          {"waited_for_core_s", outcome.cost.waited_for_core_s},
          {"wall_s", outcome.cost.wall_s}};
}

/// Tells on standard error which runs failed. Returns the exit code: 0 where none did.
int told_failures(const Comparison& comparison) {
  const std::string failures = failures_text(comparison);
  if (failures.empty()) return 0;
  tell(fmt::format("tactor: runs that failed, whose metrics are missing:\n{}", failures));
  return 1;
}

/// A line for standard error for each metric asked for that no run has reported, because of what happened in them.
std::string missing_metrics(const Study& study) {
  std::string out;
  for (const std::string& metric : study.spec.metrics) {
    const auto& columns = study.comparison.columns;
    if (std::any_of(columns.begin(), columns.end(), [&](const Column& c) { return c.metric == metric; })) continue;
    const MetricInfo* info = study.comparison.info(metric);
    const std::string why = info == nullptr || info->missing.empty() ? "" : "; it is missing where " + info->missing;
    out += fmt::format("tactor: metrics: {}: no run has reported it{}\n", metric, why);
  }
  return out;
}

/// Notes in each row in what its scene differs from that of the first, and draws those that differ.
std::string tell_scenes_apart(Comparison& comparison, const std::vector<RunCase>& cases, Registry& registry) {
  const auto scene_of = [&](const RunCase& c) { return load_graph(c.graph, registry, c.overrides).scene; };
  const auto figure_of = [&](const Scene& scene, std::size_t row) {
    return scene_figure(scene, "The scene of " + breakable(comparison.rows[row].graph) + " as the run begins.");
  };
  const Scene first = scene_of(cases.front());
  std::string figures = figure_of(first, 0);
  for (std::size_t i = 1; i < cases.size(); ++i) {
    const Scene scene = scene_of(cases[i]);
    comparison.rows[i].unlike = scene_difference(scene, first, comparison.rows.front().graph);
    if (!comparison.rows[i].unlike.empty()) figures += figure_of(scene, i);
  }
  return figures;
}

/// Runs the worst cells anew in workers, `jobs` at once. False where it was interrupted; a worker that ends costs the
/// recording of its cell.
bool record_worst(StabilityMaps& maps, const Study& study, const std::vector<RunCase>& cases, Registry& registry,
                  const fs::path& folder, unsigned jobs) {
  // What an earlier report left does not belong to this one.
  std::error_code ignored;
  fs::remove_all(folder / "worst", ignored);
  const std::vector<StabilityCell*> cells = worst_cells(maps, study);
  const auto record = [&](const std::string& job, const PoolLink& pool) {
    std::pair<std::string, std::string> recorded;  // its folder, or why it failed
    const StabilityCell& cell = *cells[from_bytes<std::size_t>(job)];
    try {
      recorded.first = record_cell(cell, study, cases[cell.row], registry, folder, [&] { return !pool.go_on(); });
    } catch (const std::exception& error) {
      recorded.second = error.what();
    }
    return to_bytes(recorded);
  };
  WorkerPool pool(record, [] { return interruption.load(); });
  JobBatch batch;
  batch.jobs = cells.size();
  batch.at_once = jobs;
  batch.job = [](std::size_t i) { return to_bytes(i); };
  batch.done = [&](std::size_t i, const std::string& answer) {
    auto [recording, failure] = from_bytes<std::pair<std::string, std::string>>(answer);
    if (!failure.empty()) throw RunError(failure);
    cells[i]->recording = std::move(recording);
    return true;
  };
  batch.lost = [&](std::size_t i, const Ending& ending) {
    const RunCase& c = cases[cells[i]->row];
    tell_note(fmt::format("the recording of {}: {}; the others go on", case_name(graph_name(c.graph), c.configuration),
                          ending.text));
  };
  return pool.run(batch);
}

}  // namespace

int run_study(const StudyRequest& request) {
  StudySpec spec = load_study(request.file, request.is_short);
  if (request.seeds) spec.seeds = *request.seeds;
  if (request.first_seed) spec.first_seed = *request.first_seed;
  if (request.repeats) {
    const Repeats repeats = warmed_up(*request.repeats);
    spec.repeats = repeats.count;
    spec.warm_up = repeats.warm_up;
  }
  const fs::path folder = request.out.value_or(fs::path("out") / spec.name);
  refuse_results_of_runs(folder);
  std::vector<RunCase> cases = study_cases(spec, request.overrides);
  CasesOptions options;
  options.seeds = seeds_from(spec.first_seed, spec.seeds);
  options.reference_jobs = request.jobs;
  options.jobs = request.jobs;
  options.repeats = spec.repeats;
  options.warm_up = spec.warm_up;
  options.without_reference = spec.without_reference;
  if (request.judge) spec.judge = *request.judge;
  options.judge_warm = spec.judge == JudgedPart::warm;
  options.refused_are_results = spec.report == StudyReport::stability;
  options.run_timeout_s = spec.run_timeout_s;
  options.table = folder / "study.sqlite";
  options.mode = request.resume ? TableMode::resume : request.overwrite ? TableMode::overwrite : TableMode::create;
  // Of the study's text only what decides how runs are made counts here; what they are, their names and graphs tell.
  options.identity = {spec.name,
                      content_key({fmt::format("{} repeats, {} warm-up, reference {}{}, judged {}", spec.repeats,
                                               spec.warm_up, spec.without_reference ? "none" : "made",
                                               spec.reference_recording, options.judge_warm ? "warm" : "whole")}),
                      options_text(request, spec),
                      {}};
  Registry registry(default_node_folders());
  options.planned = [&](const RunMetrics& metrics) { check_metrics(spec, metrics, registry); };
  if (spec.report == StudyReport::stability && !spec.record.empty()) check_record(spec, cases, registry);
  CasesOutcome outcome = run_watched(cases, registry, options);
  const std::string interrupted =
      fmt::format("interrupted: {} of {} runs are kept in {}; the same command with --resume goes on",
                  outcome.records.size(), cases.size() * options.seeds.size(), options.table.string());
  if (outcome.interrupted) throw RunError(interrupted);
  const nlohmann::ordered_json runner = to_json(outcome);
  for (RunCase& c : cases) c.judged = outcome.judged[c.group];
  const Study study = make_study(spec, make_comparison(cases, options.seeds, std::move(outcome.records),
                                                       shown_metrics(spec), std::move(outcome.declared)));
  write_file(folder / "study.csv", study_csv(study));
  write_file(folder / "run_times.csv", run_times_csv(study));
  write_study_hdf5(folder / "study.h5", study);
  nlohmann::ordered_json json = to_json(study);
  json["runner"] = runner;
  const std::size_t columns = terminal_columns();
  fmt::print("{}", wrapped(warning_lines(study.comparison), columns));
  std::string report;
  if (spec.report == StudyReport::work_precision) {
    const WorkPrecision found = work_precision(study);
    json["work_precision"] = to_json(found);
    fmt::print("{}\n", work_precision_table(study, found, columns));
    report = write_work_precision(folder, study, found);
  } else if (spec.report == StudyReport::stability) {
    StabilityMaps maps = stability_maps(study);
    if (!find_own_values(maps, study, cases, registry, is_interrupted) ||
        !record_worst(maps, study, cases, registry, folder, request.jobs)) {
      throw RunError(interrupted);
    }
    json["stability"] = to_json(maps);
    fmt::print("{}\n", stability_table(study, maps, columns));
    report = write_stability(folder, study, maps);
  } else {
    fmt::print("{}\n", study_table(study, columns));
    report = study_report(study);
  }
  // A file that cannot be written leaves the table.
  std::fflush(stdout);
  write_file(folder / "study.json", json.dump(2) + "\n");
  write_file(folder / "report.html", report);
  fmt::print("  {}\n", (folder / "report.html").string());
  tell(missing_metrics(study));
  return spec.report == StudyReport::stability ? 0 : told_failures(study.comparison);
}

int run_compare(const CompareRequest& request) {
  refuse_seed(request.overrides);
  std::vector<RunCase> cases;
  for (const fs::path& graph : request.graphs) cases.push_back({.graph = graph, .overrides = request.overrides});
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
  Comparison comparison =
      make_comparison(cases, options.seeds, std::move(outcome.records), {}, std::move(outcome.declared));
  const std::string scenes = tell_scenes_apart(comparison, cases, registry);
  const TimingNote timing = timing_note(comparison, repeats);
  fmt::print("{}\n", comparison_table(comparison, timing, terminal_columns()));
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
