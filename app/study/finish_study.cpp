#include "app/study/finish_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/study/report/stability_map.hpp"
#include "app/study/report/study_report.hpp"
#include "app/study/report/text_tables.hpp"
#include "app/study/report/work_precision.hpp"
#include "app/study/run/worker_pool.hpp"
#include "app/study/table/study.hpp"
#include "app/study/table/study_csv.hpp"
#include "app/study/table/study_export.hpp"
#include "app/study/table/warnings.hpp"
#include "app/study/table/where.hpp"
#include "app/terminal.hpp"
#include "framework/core/bytes.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

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

/// A line for standard error for each metric asked for that no run has reported, because of what happened in them.
std::string missing_metrics(const Study& study) {
  std::string out;
  for (const std::string& metric : study.spec.metrics) {
    const auto& columns = study.comparison.columns;
    if (std::any_of(columns.begin(), columns.end(), [&](const Column& c) { return c.metric == metric; })) continue;
    const MetricInfo* info = study.comparison.info(metric);
    const std::string why = info == nullptr || info->missing.empty() ? "" : "; it is missing where " + info->missing;
    out += fmt::format("tactor: metrics: {}: no run reported it{}\n", metric, why);
  }
  return out;
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

int told_failures(const Comparison& comparison) {
  const std::string failures = failures_text(comparison);
  if (failures.empty()) return 0;
  tell(fmt::format("tactor: runs that failed, whose metrics are missing:\n{}", failures), LogLevel::error);
  return 1;
}

int finish_study(const StudySpec& spec, std::vector<RunCase> cases, CasesOutcome outcome, Registry& registry,
                 const FinishOptions& options) {
  const fs::path& folder = options.folder;
  nlohmann::ordered_json runner = to_json(outcome);
  for (RunCase& c : cases) c.judged = outcome.judged[c.group];
  std::vector<std::string> where = where_runs_were_made(outcome.records);
  where.insert(where.end(), options.where.begin(), options.where.end());
  Study study = make_study(spec, make_comparison(cases, options.seeds, std::move(outcome.records), shown_metrics(spec),
                                                 std::move(outcome.declared)));
  study.comparison.where = where;
  study.comparison.provenance = outcome.provenance;
  study.comparison.further_warnings.insert(study.comparison.further_warnings.end(), options.warnings.begin(),
                                           options.warnings.end());
  write_file(folder / "study.csv", study_csv(study));
  write_file(folder / "run_times.csv", run_times_csv(study));
  remove_link(folder / "study.h5");
  write_study_hdf5(folder / "study.h5", study);
  nlohmann::ordered_json json = to_json(study);
  runner["where"] = where;
  runner.update(nlohmann::ordered_json::parse(options.runner));
  json["runner"] = std::move(runner);
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
        !record_worst(maps, study, cases, registry, folder, options.jobs)) {
      throw RunError(options.interrupted);
    }
    json["stability"] = to_json(maps);
    fmt::print("{}\n", stability_table(study, maps, columns));
    report = write_stability(folder, study, maps);
  } else {
    fmt::print("{}\n", study_table(study, columns));
    report = study_report(study);
  }
  for (const std::string& sentence : where) fmt::print("{}", wrapped("  " + sentence + "\n", columns));
  // A file that cannot be written leaves the table.
  std::fflush(stdout);
  write_file(folder / "study.json", json.dump(2) + "\n");
  write_file(folder / "report.html", report);
  fmt::print("  {}\n", (folder / "report.html").string());
  tell(missing_metrics(study));
  return spec.report == StudyReport::stability ? 0 : told_failures(study.comparison);
}

}  // namespace tactor
