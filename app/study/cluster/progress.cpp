#include "app/study/cluster/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Which chunks of a stage have a shard, by the names of the files alone: asked every second, and shards may be many.
std::set<std::size_t> chunks_with_shards(const ClusterFolder& folder, const Stage& stage) {
  std::set<std::size_t> chunks;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.shards(stage.kind), ignored)) {
    if (entry.path().extension() != ".shard") continue;
    const std::string stem = entry.path().stem().string();
    if (stem.empty() || stem.size() > 9 || stem.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::size_t chunk = std::stoul(stem);
    if (chunk < stage.chunks()) chunks.insert(chunk);
  }
  return chunks;
}

}  // namespace

ClusterProgress find_progress(const ClusterPlan& plan, const ClusterFolder& folder,
                              const std::map<std::string, JobCounts>& counts) {
  ClusterProgress progress;
  std::error_code ignored;
  progress.is_merged = fs::exists(folder.merged(), ignored);
  std::map<StageKind, JobCounts> by_stage;
  for (const Submission& submission : read_submissions(folder)) {
    if (submission.job.empty()) continue;
    progress.jobs.push_back(submission.job);
    const auto found = counts.find(submission.job);
    if (found == counts.end()) continue;
    by_stage[submission.stage].waiting += found->second.waiting;
    by_stage[submission.stage].running += found->second.running;
    progress.is_alive = progress.is_alive || found->second.waiting + found->second.running > 0;
  }
  double expected_s = 0, done_s = 0;
  for (const StageKind kind : all_stages) {
    const Stage* stage = plan.stage(kind);
    StageProgress one{kind};
    if (stage != nullptr) {
      one.tasks = stage->chunks();
      one.units = stage->units();
      const std::vector<double>& costs = plan.costs.of(kind);
      const auto cost_of = [&](std::size_t chunk) {
        double sum = 0;
        for (std::size_t unit = stage->chunk_begin[chunk]; unit < stage->chunk_begin[chunk + 1]; ++unit) {
          sum += costs[stage->cases[unit / plan.planned.seeds()]];
        }
        return sum;
      };
      for (std::size_t chunk = 0; chunk < stage->chunks(); ++chunk) expected_s += cost_of(chunk);
      for (const std::size_t chunk : chunks_with_shards(folder, *stage)) {
        ++one.done;
        one.units_done += stage->chunk_begin[chunk + 1] - stage->chunk_begin[chunk];
        done_s += cost_of(chunk);
      }
    } else if (kind == StageKind::merge || (kind == StageKind::intervals && plan.stage(StageKind::warm) != nullptr)) {
      one.tasks = 1;
      one.done = fs::exists(kind == StageKind::merge ? folder.merged() : folder.intervals(), ignored) ? 1 : 0;
    } else {
      continue;
    }
    one.waiting = by_stage[kind].waiting;
    one.running = by_stage[kind].running;
    // Some systems tell of an array that waits as one. What a stage lacks is missing once nothing of it is left there.
    if (one.running + one.waiting > 0) {
      one.waiting = std::max(one.waiting, one.tasks - std::min(one.tasks, one.done + one.running));
    }
    progress.stages.push_back(one);
  }
  progress.share = expected_s > 0 ? done_s / expected_s : 1;
  return progress;
}

std::string progress_text(const ClusterPlan& plan, const ClusterFolder& folder, const ClusterProgress& progress,
                          const std::string& system) {
  std::string text =
      fmt::format("{} in {}: {} runs by {}\n\n", plan.spec.name, folder.out().string(), plan.planned.runs(), system);
  text += fmt::format("  {:<11} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "stage", "tasks", "done", "running", "waiting",
                      "missing");
  for (const StageProgress& stage : progress.stages) {
    const std::size_t known = stage.done + stage.running + stage.waiting;
    text += fmt::format("  {:<11} {:>8} {:>8} {:>8} {:>8} {:>8}", name_of(stage.stage), stage.tasks, stage.done,
                        stage.running, stage.waiting, stage.tasks > known ? stage.tasks - known : 0);
    if (stage.units > 0) text += fmt::format("   {} of {} runs", stage.units_done, stage.units);
    text += "\n";
  }
  text += fmt::format("\n  jobs {}\n", fmt::join(progress.jobs, " "));
  if (progress.is_merged) return text + "  done\n";
  if (progress.is_alive) return text;
  return text + fmt::format("  nothing waits or runs any more: tactor study {} --resume makes what is missing\n",
                            folder.out().string());
}

}  // namespace tactor
