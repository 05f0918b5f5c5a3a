// Cases whose graphs have been read and checked: all there is to know of their runs, and the jobs that make them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/run/provenance.hpp"
#include "app/study/plan/run_case.hpp"
#include "app/study/run/job.hpp"
#include "app/study/table/run_table.hpp"

namespace tactor {

class WorkerPool;
struct Ending;

/// How cases are run, wherever that is.
struct CasesSettings {
  std::vector<std::uint64_t> seeds;
  std::int64_t repeats = 1;  ///< of every run; run times are their medians
  std::int64_t warm_up = 0;  ///< runs before these that do not count
  /// Judges the cases of a group on one interval, from when the nodes of all of them are warm on; false: each run from
  /// its start.
  bool judge_warm = false;
  bool without_reference = false;  ///< no reference runs: metrics that need one are left out
  /// Of real time, for every repeat of a run and every reference run: one that ends later has failed, and the worker
  /// of one that does not end is killed.
  std::optional<double> run_timeout_s;
  /// Cases that are refused as bad input are results, unless all are.
  bool refused_are_results = false;
  TableIdentity identity;            ///< of the table of runs
  std::filesystem::path study_file;  ///< absolute; empty for a comparison
};

/// Why a run cannot be made.
struct Obstacle {
  RunStatus status = RunStatus::failed;
  std::string message;
  bool may_differ = false;  ///< next time
};

/// Of runs whose reference run took its worker with it.
Obstacle lost_reference(const Ending& ending);

/// Runs are numbered: case * seeds + seed.
struct PlannedCases {
  std::vector<RunCase> cases;
  CasesSettings settings;
  std::vector<CaseCheck> checks;                   ///< by case, without notes, metrics and files of code
  std::vector<std::optional<Obstacle>> obstacles;  ///< likewise
  std::set<std::string> libraries;                 ///< of nodes, that the cases need
  std::set<std::filesystem::path> code_files;      ///< as code_files(), of all cases
  std::set<std::string> codes;                     ///< NodeInfo::code of the nodes in Python
  std::set<std::filesystem::path> inputs;          ///< files that the runs depend on
  std::set<std::filesystem::path> loaded;          ///< programs and libraries, ours and others, that the cases load
  /// By case: the first case with the same reference runs, which serve both; itself where it needs none.
  std::vector<std::size_t> reference_case;
  std::vector<JudgedFrom> judged;  ///< by group; from the start until judged_intervals has found more

  [[nodiscard]] std::size_t seeds() const { return settings.seeds.size(); }
  [[nodiscard]] std::size_t runs() const { return cases.size() * seeds(); }
  [[nodiscard]] std::uint64_t seed_of(std::size_t run) const { return settings.seeds[run % seeds()]; }
  [[nodiscard]] std::string graph_of(std::size_t c) const;
  [[nodiscard]] std::string name_of(std::size_t run) const;
  [[nodiscard]] bool needs_reference(std::size_t c) const { return !checks[c].reference.empty() && !obstacles[c]; }
  /// Whether it has to be found when the case is warm.
  [[nodiscard]] bool has_to_warm_up(std::size_t c) const;
  [[nodiscard]] Job job(JobKind kind, std::size_t run, const std::filesystem::path& cache_folder) const;
  /// What tells the runs apart in a table, by number.
  [[nodiscard]] std::vector<RunName> names() const;
  /// The hash of the recording that judges a run; empty where a reference run does.
  [[nodiscard]] std::string recording_hash(std::size_t run) const;
  /// A run that cannot be made, as a row.
  [[nodiscard]] RunRecord hopeless(std::size_t run, const Obstacle& obstacle) const;
};

/// What planning tells while it goes on; both may be empty.
struct PlanningHooks {
  std::function<void(const std::string& note)> note;
  /// Called once, with what the runs report and the run times that tables show; may throw.
  std::function<void(const RunMetrics&)> planned;
};

/// Reads and checks the graphs of all cases, `at_once` at a time. Throws InputError where a case is refused and may not
/// be, RunError where it was interrupted.
PlannedCases plan_cases(const std::vector<RunCase>& cases, const CasesSettings& settings, WorkerPool& pool,
                        const std::filesystem::path& cache_folder, unsigned at_once, const PlanningHooks& hooks);

/// The provenance of the table of these runs, made now. Of libraries that a run alone loads, such as a BLAS, it has
/// none.
Provenance provenance_of(const PlannedCases& planned, const std::filesystem::path& cache_folder);

/// From when on each group is judged, by what is known of when its runs are warm (by number; a run that failed before
/// is not there). Throws InputError where a run never is, or where too little is left.
std::vector<JudgedFrom> judged_intervals(const PlannedCases& planned, const std::map<std::size_t, Warmth>& warmths);

}  // namespace tactor
