// The order of work of studies and comparisons: cases with seeds, as jobs of a pool of workers, into one table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/study/plan/run_case.hpp"
#include "app/study/run/planned_cases.hpp"
#include "app/study/table/run_table.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

class Registry;

struct CasesOptions : CasesSettings {
  unsigned reference_jobs = 2;  ///< reference runs at once, and cases that are planned at once
  unsigned jobs = 1;            ///< runs under test at once; metrics do not depend on it
  bool curves = false;          ///< keep all curves of the first seed, for reports
  std::filesystem::path cache_folder;
  std::filesystem::path table;  ///< its folder is made; InputError where that cannot be
  TableMode mode = TableMode::create;
  std::function<void(double share, const std::string& what)> progress;  ///< may be empty, as may `note`
  std::function<void(const std::string& note)> note;                    ///< as RunOptions::note
  std::function<int()> interruptions = [] { return 0; };                ///< as in WorkerPool
  /// Called once before the first run, with what the runs report and the run times that tables show; may throw.
  std::function<void(const RunMetrics&)> planned;
};

/// What the study runner spent, for its overhead.
struct CasesCost {
  double total_cpu_s = 0;        ///< of all its processes, from the first run to the last
  double run_cpu_s = 0;          ///< of these, in runs: planning, nodes made, warm-up, repeats, judging
  double reference_cpu_s = 0;    ///< in reference runs made beforehand
  double waited_for_core_s = 0;  ///< in which workers were ready to run and other programs had the cores
  double wall_s = 0;
};

/// All runs of the cases, one a case and seed: number = case * seeds + seed.
struct CasesOutcome {
  std::vector<RunRecord> records;  ///< by number; with all runs there unless interrupted
  MetricMap declared;              ///< what the runs that are done may report
  std::size_t found = 0;           ///< runs that the table had before the command
  std::size_t crashes = 0;         ///< workers that ended in the middle of a job
  bool interrupted = false;
  std::vector<JudgedFrom> judged;  ///< by group
  CasesCost cost;
  Provenance provenance;
};

/// Checks every case, then runs what the table does not have. A run that fails is a record with its message. Throws
/// InputError where a case is refused and may not be, before anything runs. Forks workers, so the program must have no
/// other thread.
CasesOutcome run_cases(const std::vector<RunCase>& cases, Registry& registry, const CasesOptions& options);

}  // namespace tactor
