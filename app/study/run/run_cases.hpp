// The engine of studies and comparisons: runs cases with seeds on threads, into a table that survives anything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/study/plan/run_case.hpp"
#include "app/study/table/run_table.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

class Registry;
class Supervisor;

struct CasesOptions {
  std::vector<std::uint64_t> seeds;
  unsigned reference_jobs = 2;     ///< reference runs at once
  unsigned jobs = 1;               ///< runs under test at once; metrics do not depend on it
  std::int64_t repeats = 1;        ///< of every run; run times are their medians
  std::int64_t warm_up = 0;        ///< runs before these that do not count
  bool without_reference = false;  ///< no reference runs: metrics that need one are left out
  /// Of real time, for every repeat of a run and every reference run: a run that ends later has failed, and a
  /// supervisor ends what does not end.
  std::optional<double> run_timeout_s;
  bool curves = false;  ///< keep all curves of the first seed, for reports
  /// Cases that are refused as bad input are results, unless all are.
  bool refused_are_results = false;
  std::filesystem::path cache_folder;
  std::filesystem::path table;  ///< its folder is made; InputError where that cannot be
  TableMode mode = TableMode::create;
  /// Whose process this is: runs that crash it are tried alone, and are failed where they do so again. Null: a crash
  /// ends the runs.
  Supervisor* supervisor = nullptr;
  TableIdentity identity;                                               ///< its program is filled in
  std::function<bool(double share, const std::string& what)> progress;  ///< false interrupts; by one thread at a time
  std::function<void(const std::string& note)> note;  ///< as RunOptions::note, by one thread at a time
  std::function<bool()> interrupted;                  ///< true interrupts; may be asked by several threads at once
  /// Called once before the first run, with what the runs report and the run times that tables show; may throw.
  std::function<void(const RunMetrics&)> planned;
};

/// What the engine spent, for its overhead; without what processes spent that crashed.
struct CasesCost {
  double total_cpu_s = 0;        ///< of the process, from the first run to the last
  double run_cpu_s = 0;          ///< of these, in runs: planning, nodes made, warm-up, repeats, judging
  double reference_cpu_s = 0;    ///< in reference runs made beforehand
  double waited_for_core_s = 0;  ///< in which threads were ready to run and other programs had the cores
  double wall_s = 0;
};

/// All runs of the cases, one a case and seed: number = case * seeds + seed.
struct CasesOutcome {
  std::vector<RunRecord> records;  ///< by number; with all runs there unless interrupted
  MetricMap declared;              ///< what the runs that are done may report
  std::size_t found = 0;           ///< runs that the table had before the command
  std::size_t crashes = 0;         ///< of processes before this one
  bool interrupted = false;
  CasesCost cost;
};

/// Checks every case, then runs what the table does not have. A run that fails is a record with its message. Throws
/// InputError where a case is refused and may not be, before anything runs.
CasesOutcome run_cases(const std::vector<RunCase>& cases, Registry& registry, const CasesOptions& options);

}  // namespace tactor
