// From when on the runs of a study on a cluster are judged: found by one task, read by those that make the runs.
#pragma once

#include <vector>

#include "app/study/cluster/cluster_plan.hpp"

namespace tactor {

/// Finds the intervals by the shards of the stage `warm`, and keeps them in cluster/intervals.bin, or in their place
/// why the study is refused. Returns the exit code. Throws RunError where a shard is missing.
int find_intervals(const ClusterPlan& plan, const ClusterFolder& folder);

/// Whether read_intervals would not throw RunError.
bool has_intervals(const ClusterPlan& plan, const ClusterFolder& folder);

/// The intervals by group; those of the plan where the study need not warm up. Throws RunError where they are not there
/// yet, InputError where the study was refused.
std::vector<JudgedFrom> read_intervals(const ClusterPlan& plan, const ClusterFolder& folder);

}  // namespace tactor
