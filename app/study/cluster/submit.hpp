// Hands the tasks of a study that are still to be made to a cluster.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "app/study/cluster/cluster_plan.hpp"
#include "app/study/cluster/cluster_system.hpp"
#include "app/study/cluster/submission.hpp"

namespace tactor {

/// Throws InputError where a name could not stand in the scripts of jobs, of the study, its folder or a variable of the
/// environment.
void check_job_scripts(const StudySpec& study, const std::filesystem::path& out);

/// Submits what is missing: tasks for the chunks without a whole shard, the intervals where they are not known, and the
/// merge at the end of all. Returns the new submissions. Throws RunError where the cluster refuses; what it had taken
/// by then is cancelled again.
std::vector<Submission> submit_missing(const ClusterPlan& plan, const ClusterFolder& folder,
                                       const ClusterSystem& system, const ClusterOptions& options);

// For these the judged intervals of the plan are those of cluster/intervals.bin, where it is there.

/// The chunks of a stage that have no whole shard.
std::vector<std::size_t> missing_chunks(const ClusterPlan& plan, const ClusterFolder& folder, const Stage& stage);

/// Takes runs out of the shards, so that they are made anew: those that may end otherwise another time, because the
/// machine or a time limit ended them, and those whose processor does not count (see counted_processor).
void forget_what_does_not_count(const ClusterPlan& plan, const ClusterFolder& folder);

}  // namespace tactor
