// Makes the units of one chunk into a shard.
#pragma once

#include <cstddef>

#include "app/study/cluster/cluster_plan.hpp"

namespace tactor {

/// As run_cluster_task, for a stage with chunks.
int run_chunk(const ClusterPlan& plan, const ClusterFolder& folder, StageKind stage, std::size_t chunk);

}  // namespace tactor
