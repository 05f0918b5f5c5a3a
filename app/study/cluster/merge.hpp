// The shards of a study on a cluster, as the table that one machine would have made of the same study.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/run/ran_on.hpp"
#include "app/study/cluster/cluster_plan.hpp"
#include "app/study/cluster/shard.hpp"
#include "app/study/table/run_table.hpp"

namespace tactor {

/// What became of the shards.
struct MergedShards {
  std::vector<RunRecord> records;           ///< all there are, by number
  MetricMap declared;                       ///< what they may report
  std::vector<std::size_t> missing_chunks;  ///< of the stage runs: absent, damaged or not whole
  std::size_t missing_runs = 0;             ///< that no shard has
  std::size_t left_out = 0;                 ///< of these: made on a processor that computes otherwise than most
  std::string depends_because;              ///< why that matters; empty: nothing depends on the processor
  std::vector<std::string> damaged;         ///< files, and what is wrong with them
  std::size_t twice = 0;                    ///< runs that two tasks have made
  std::vector<std::string> unlike_twice;    ///< names of those that gave other results the second time
  double core_s = 0;                        ///< that the tasks had a core, of all stages, made twice or not
  double cpu_s = 0;                         ///< of these, CPU time
  double run_cpu_s = 0;                     ///< CPU time in jobs
  std::size_t shards = 0;                   ///< that were read
};

/// The shard of a chunk, whole or in part, where one is there that belongs to the chunk. What is wrong with files that
/// were looked at is added to `damaged`, where that is not null. Of runs the judged intervals of the plan must be
/// known.
std::optional<Shard> find_shard(const ClusterPlan& plan, const ClusterFolder& folder, StageKind stage,
                                std::size_t chunk, std::vector<std::string>* damaged);

/// Whether a run of a shard counts where `processor` is what counted_processor has found.
bool counts_on(const std::optional<RanOn>& processor, const Shard& shard, const RunRecord& run);

/// The processor and C library whose runs count, where the last digits of some run depend on them: those that made most
/// runs. Nothing where all that were used compute alike, or where no run depends on them. `because`, where not null,
/// becomes what depends on them.
std::optional<RanOn> counted_processor(const ClusterPlan& plan, const ClusterFolder& folder, std::string* because);

/// Puts the runs of all shards into a new table at `file`, sorted by number, and tells what is missing. The bytes of
/// the file depend on the runs alone, not on how they were cut into shards. Uses the node's own disk until it is whole,
/// or where that refuses a folder beside the shards.
MergedShards merge_shards(const ClusterPlan& plan, const ClusterFolder& folder, const std::filesystem::path& file);

}  // namespace tactor
