#include "app/study/cluster/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "framework/core/shell_word.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Which chunks of a stage have a shard, by the names of the files alone: asked every second, and shards may be many.
std::set<std::size_t> chunks_with_shards(const ClusterFolder& folder, const Stage& stage) {
  std::set<std::size_t> chunks;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.shards(stage.kind), ignored)) {
    if (entry.path().extension() != shard_ending) continue;
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
  if (std::ifstream merged(folder.merged()); merged) {
    const nlohmann::json json = nlohmann::json::parse(merged, nullptr, false);
    progress.is_merged = true;
    progress.merge_code = json.is_object() ? json.value("exit_code", 1) : 1;
    progress.merge_said = json.is_object() ? json.value("message", "") : folder.merged().string() + " is damaged";
  }
  std::map<StageKind, JobCounts> by_stage;
  for (const Submission& submission : read_submissions(folder)) {
    if (submission.job.empty()) continue;
    const auto found = counts.find(submission.job);
    if (found == counts.end()) continue;
    by_stage[submission.stage].waiting += found->second.waiting;
    by_stage[submission.stage].running += found->second.running;
    by_stage[submission.stage].held += found->second.held;
    if (found->second.held > 0) progress.held.push_back(submission.job);
    if (found->second.waiting + found->second.running > 0) progress.jobs.push_back(submission.job);
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
    one.held = by_stage[kind].held;
    // Some systems tell of an array that waits as one. What a stage lacks is missing once nothing of it is left there.
    if (one.running + one.waiting > 0) {
      one.waiting = std::max(one.waiting, one.tasks - std::min(one.tasks, one.done + one.running));
    }
    progress.stages.push_back(one);
  }
  progress.is_alive = !progress.jobs.empty();
  progress.share = expected_s > 0 ? done_s / expected_s : 1;
  return progress;
}

std::string complaints(const ClusterFolder& folder) {
  constexpr std::size_t most = 3;  // logs
  std::vector<fs::path> logs;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.jobs(), ignored)) {
    if (entry.path().extension() == ".log" && entry.file_size(ignored) > 0) logs.push_back(entry.path());
  }
  std::sort(logs.rbegin(), logs.rend());
  std::string text;
  std::size_t told = 0;
  for (const fs::path& log : logs) {
    std::ifstream file(log);
    std::string line;
    // Slurm's own lines tell that a task was ended, which is known.
    while (std::getline(file, line) && (line.empty() || line.starts_with("slurmstepd") || line.starts_with("slurmd"))) {
    }
    if (line.empty() || told++ == most) continue;
    text += fmt::format("  {}: {}\n", log.string(), line);
  }
  return text;
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
    if (stage.held > 0) text += fmt::format("   {} held", stage.held);
    text += "\n";
  }
  text += "\n";
  if (!progress.held.empty()) {
    text += fmt::format(
        "  {} holds tasks of jobs {}: they begin when someone releases them (on Slurm: scontrol release JOB)\n", system,
        fmt::join(progress.held, " "));
  }
  if (progress.is_alive) return text + fmt::format("  jobs {}\n", fmt::join(progress.jobs, " "));
  const bool is_whole = std::all_of(progress.stages.begin(), progress.stages.end(),
                                    [](const StageProgress& stage) { return stage.done == stage.tasks; });
  if (progress.is_merged && progress.merge_said.empty() && is_whole) {
    return text + fmt::format("  done: {}\n", (folder.out() / "report.html").string());
  }
  if (!progress.merge_said.empty()) text += fmt::format("  the merge has failed: {}\n", progress.merge_said);
  text += complaints(folder);
  return text + fmt::format("  nothing waits or runs any more: tactor study {} --resume runs what is missing\n",
                            as_typed(folder.out().string()));
}

}  // namespace tactor
