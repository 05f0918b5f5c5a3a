// How far a study on a cluster is.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/study/cluster/cluster_plan.hpp"
#include "app/study/cluster/cluster_system.hpp"
#include "app/study/cluster/submission.hpp"

namespace tactor {

struct StageProgress {
  StageKind stage = StageKind::runs;
  std::size_t tasks = 0, done = 0, running = 0, waiting = 0;
  std::size_t held = 0;                   ///< of those that wait, until someone lets them begin
  std::size_t units = 0, units_done = 0;  ///< 0 for a stage of one task
};

struct ClusterProgress {
  std::vector<StageProgress> stages;
  std::vector<std::string> jobs;  ///< of which a task waits or runs
  std::vector<std::string> held;  ///< of which a task is held
  bool is_alive = false;          ///< a task of them waits or runs
  bool is_merged = false;         ///< the merge has ended, well or not
  int merge_code = 0;             ///< the exit code of the merge
  std::string merge_said;         ///< why it has failed; empty: it has not
  /// The share that is done, by what the units are expected to take.
  double share = 0;
};

/// `counts`: what the cluster answers, by ask_for_jobs.
ClusterProgress find_progress(const ClusterPlan& plan, const ClusterFolder& folder,
                              const std::map<std::string, JobCounts>& counts);
/// What the newest logs of the jobs complain of: a line for each log, its first. Empty where they say nothing.
std::string complaints(const ClusterFolder& folder);
/// A table with a line a stage.
std::string progress_text(const ClusterPlan& plan, const ClusterFolder& folder, const ClusterProgress& progress,
                          const std::string& system);

}  // namespace tactor
