#include "app/study/cluster/merge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "app/output.hpp"
#include "app/study/cluster/shard.hpp"
#include "app/study/run/job_fields.hpp"
#include "framework/core/temporary_folder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Whether two results of one run are the same to the bit, apart from run times.
bool same_result(const RunRecord& a, const RunRecord& b) {
  const auto same_metric = [](const auto& x, const auto& y) {
    return x.first == y.first && std::memcmp(&x.second, &y.second, sizeof x.second) == 0;
  };
  const auto& left = a.result.metrics;
  const auto& right = b.result.metrics;
  return a.status == b.status && std::equal(left.begin(), left.end(), right.begin(), right.end(), same_metric);
}

using Records = std::map<std::size_t, RunRecord>;  // by unit

/// Merges the shards of one plan.
class ShardMerge {
 public:
  ShardMerge(const ClusterPlan& plan, const ClusterFolder& folder)
      : plan_(plan), planned_(plan.planned), folder_(folder), stage_(plan.stage(StageKind::runs)) {}

  /// `scratch`: a folder for the table until it is whole.
  MergedShards run(const fs::path& scratch, const fs::path& file) {
    count_other_stages();
    processor_ = counted_processor(plan_, folder_, &merged_.depends_because);
    RunTable table(scratch / "merge.sqlite", TableMode::create, planned_.settings.identity, planned_.names());
    std::size_t chunk = 0;
    for (std::size_t c = 0; c < planned_.cases.size(); ++c) {
      if (planned_.obstacles[c]) {
        add_hopeless(c, table);
        continue;
      }
      // The first chunk that begins in this case or later, since a chunk may hold several cases.
      for (; stage_ != nullptr && chunk < stage_->chunks() && case_of(stage_->chunk_begin[chunk]) == c; ++chunk) {
        add_chunk(chunk);
        // Rows of cases without runs stand between those of a chunk.
        flush(c, table);
      }
      flush(c, table);
    }
    const fs::path whole = scratch / "study.sqlite";
    table.save_as(whole);
    publish_last(whole, file);
    merged_.records = table.read();
    merged_.declared = table.declared();
    return std::move(merged_);
  }

 private:
  [[nodiscard]] std::size_t case_of(std::size_t unit) const { return plan_.run_of(*stage_, unit) / planned_.seeds(); }

  [[nodiscard]] bool belongs(const Shard& shard, StageKind stage, std::size_t chunk) const {
    return shard.head.is_of(plan_.shard_key(stage), name_of(stage), chunk);
  }

  void count(const Shard& shard) {
    merged_.core_s += shard.cost.wall_s;
    merged_.cpu_s += shard.cost.cpu_s;
    merged_.run_cpu_s += shard.cost.run_cpu_s;
    ++merged_.shards;
  }

  std::optional<Shard> find(StageKind stage, std::size_t chunk) {
    return find_shard(plan_, folder_, stage, chunk, &merged_.damaged);
  }

  void count_other_stages() {
    for (const Stage& stage : plan_.stages) {
      if (stage.kind == StageKind::runs) continue;
      for (std::size_t chunk = 0; chunk < stage.chunks(); ++chunk) {
        if (const std::optional<Shard> shard = find(stage.kind, chunk)) count(*shard);
      }
    }
    for (const Stage& stage : plan_.stages) {
      for (const fs::path& twin : folder_.twins(stage.kind)) {
        const std::optional<Shard> shard = read_shard(twin);
        if (shard && shard->head.plan == plan_.shard_key(stage.kind)) count(*shard);
      }
    }
  }

  void add_chunk(std::size_t chunk) {
    const std::optional<Shard> shard = find(StageKind::runs, chunk);
    const std::size_t units = stage_->chunk_begin[chunk + 1] - stage_->chunk_begin[chunk];
    std::size_t found = 0;
    if (shard) {
      count(*shard);
      Records records = records_of(*shard, chunk);
      compare_twins(chunk, records);
      found = records.size();
      pending_.merge(records);
    }
    if (found == units && shard->complete) return;
    merged_.missing_chunks.push_back(chunk);
    merged_.missing_runs += units - found;
  }

  Records records_of(const Shard& shard, std::size_t chunk) {
    Records records;
    for (const auto& [unit, answer] : shard.records) {
      if (unit < stage_->chunk_begin[chunk] || unit >= stage_->chunk_begin[chunk + 1]) continue;
      std::optional<RunRecord> record = from_message<RunAnswer>(answer).record;
      if (!record) continue;
      if (!counts_on(processor_, shard, *record)) {
        ++merged_.left_out;
        continue;
      }
      record->number = plan_.run_of(*stage_, unit);
      records.emplace(unit, std::move(*record));
    }
    return records;
  }

  void compare_twins(std::size_t chunk, const Records& records) {
    if (!twins_) twins_ = folder_.twins(StageKind::runs);
    for (const fs::path& file : *twins_) {
      if (!folder_.is_twin_of(file, chunk)) continue;
      const std::optional<Shard> twin = read_shard(file);
      if (!twin || !belongs(*twin, StageKind::runs, chunk)) continue;
      for (const auto& [unit, answer] : twin->records) {
        const auto first = records.find(unit);
        const std::optional<RunRecord> second = from_message<RunAnswer>(answer).record;
        if (first == records.end() || !second) continue;
        ++merged_.twice;
        // What the machine or a time limit ended may end otherwise.
        if (first->second.may_differ || second->may_differ) continue;
        if (!same_result(first->second, *second))
          merged_.unlike_twice.push_back(planned_.name_of(first->second.number));
      }
    }
  }

  void add_hopeless(std::size_t c, RunTable& table) {
    std::vector<RunRecord> rows;
    for (std::size_t s = 0; s < planned_.seeds(); ++s) {
      rows.push_back(planned_.hopeless(c * planned_.seeds() + s, *planned_.obstacles[c]));
    }
    table.add(rows);
  }

  /// Writes what is there of the runs up to this case.
  void flush(std::size_t c, RunTable& table) {
    std::vector<RunRecord> rows;
    while (!pending_.empty() && pending_.begin()->second.number < (c + 1) * planned_.seeds()) {
      rows.push_back(std::move(pending_.extract(pending_.begin()).mapped()));
    }
    if (!rows.empty()) table.add(rows);
  }

  const ClusterPlan& plan_;
  const PlannedCases& planned_;
  const ClusterFolder& folder_;
  const Stage* stage_;
  std::optional<RanOn> processor_;
  std::optional<std::vector<fs::path>> twins_;
  Records pending_;  // read and not written yet
  MergedShards merged_;
};

}  // namespace

std::optional<Shard> find_shard(const ClusterPlan& plan, const ClusterFolder& folder, StageKind stage,
                                std::size_t chunk, std::vector<std::string>* damaged) {
  for (const fs::path& file : {folder.shard(stage, chunk), folder.part(stage, chunk)}) {
    std::optional<Shard> shard = read_shard(file);
    if (!shard) continue;
    const bool is_mine = shard->head.is_of(plan.shard_key(stage), name_of(stage), chunk);
    const std::string wrong = !shard->damage.empty() ? shard->damage : is_mine ? "" : "it is of another task or study";
    if (damaged != nullptr && !wrong.empty()) damaged->push_back(file.string() + ": " + wrong);
    if (is_mine) return shard;
  }
  return std::nullopt;
}

bool counts_on(const std::optional<RanOn>& processor, const Shard& shard, const RunRecord& run) {
  return !processor || shard.depends_on_processor.empty() || run.ran_on.processor.empty() ||
         run.ran_on.computes_as(*processor);
}

std::optional<RanOn> counted_processor(const ClusterPlan& plan, const ClusterFolder& folder, std::string* because) {
  const Stage* stage = plan.stage(StageKind::runs);
  std::map<std::pair<std::string, std::string>, std::size_t> runs;
  std::set<std::string> reasons;
  for (std::size_t chunk = 0; stage != nullptr && chunk < stage->chunks(); ++chunk) {
    const std::optional<Shard> shard = find_shard(plan, folder, StageKind::runs, chunk, nullptr);
    if (!shard || shard->depends_on_processor.empty()) continue;
    reasons.insert(shard->depends_on_processor.begin(), shard->depends_on_processor.end());
    // A shard may hold runs of an earlier try on another node.
    for (const auto& [unit, answer] : shard->records) {
      const std::optional<RunRecord> run = from_message<RunAnswer>(answer).record;
      if (run && !run->ran_on.processor.empty()) ++runs[{run->ran_on.processor, run->ran_on.c_library}];
    }
  }
  if (runs.size() < 2) return std::nullopt;
  if (because != nullptr) *because = fmt::format("{}", fmt::join(reasons, ", "));
  const auto most =
      std::max_element(runs.begin(), runs.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return RanOn{"", most->first.first, most->first.second};
}

MergedShards merge_shards(const ClusterPlan& plan, const ClusterFolder& folder, const fs::path& file) {
  try {
    const TemporaryFolder own;
    return ShardMerge(plan, folder).run(own.path(), file);
  } catch (const RunError& error) {
    tell_note(fmt::format("{}; the table is made below {} at once", error.what(), folder.path().string()));
  }
  const TemporaryFolder shared(folder.path(), "scratch-");
  return ShardMerge(plan, folder).run(shared.path(), file);
}

}  // namespace tactor
