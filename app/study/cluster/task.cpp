#include "app/study/cluster/task.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "app/interruption.hpp"
#include "app/study/cluster/chunk_task.hpp"
#include "app/study/cluster/intervals.hpp"
#include "app/study/cluster/merge.hpp"
#include "app/study/cluster/shard.hpp"
#include "app/study/cluster/submission.hpp"
#include "app/study/finish_study.hpp"
#include "app/study/table/where.hpp"
#include "framework/core/file_descriptor.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// What makes the results of a merge doubtful.
std::vector<std::string> warnings_of(const MergedShards& merged, const ClusterPlan& plan) {
  std::vector<std::string> warnings;
  const auto say = [&](std::string text) { warnings.push_back(std::move(text)); };
  if (merged.missing_runs > 0) {
    say(fmt::format("{} of {} runs are missing, in {} tasks; cluster/jobs/*.log tells why, and --resume runs them",
                    merged.missing_runs, plan.planned.runs(), merged.missing_chunks.size()));
  }
  if (merged.left_out > 0) {
    say(
        fmt::format("{} runs were left out, because they were made by another processor or C library than most, and "
                    "their last digits depend on it ({}); make all on one kind of node, such as by --sbatch-option "
                    "--constraint=NAME",
                    merged.left_out, merged.depends_because));
  }
  if (!merged.unlike_twice.empty()) {
    say(fmt::format("{} runs gave other results when they were made a second time, such as {}",
                    merged.unlike_twice.size(), merged.unlike_twice.front()));
  }
  for (const std::string& file : merged.damaged) say(file);
  return warnings;
}

std::vector<std::string> where_of(const MergedShards& merged, const ClusterPlan& plan) {
  std::vector<std::string> where;
  where.push_back(fmt::format("{} shards took {}, of which {:.1f} % went into runs, reference runs and warm-up.",
                              merged.shards, core_time(merged.core_s),
                              merged.core_s > 0 ? 100 * merged.run_cpu_s / merged.core_s : 0));
  where.push_back(merged.twice == 0 ? "No run was made twice."
                                    : fmt::format("{} runs were made twice; {} of them gave other results.",
                                                  merged.twice, merged.unlike_twice.size()));
  if (plan.spec.repeats > 1) {
    where.push_back(plan.exclusive ? "Each task had its node to itself."
                                   : "Run times come from nodes that were shared with other programs.");
  }
  return where;
}

/// The table, and what the study reports of it.
int merge_and_report(ClusterPlan& plan, const ClusterFolder& folder) {
  plan.planned.judged = read_intervals(plan, folder);
  for (std::size_t run = 0; run < plan.recordings.size(); ++run) {
    if (plan.recordings[run] == plan.planned.recording_hash(run)) continue;
    throw InputError(plan.planned.name_of(run) +
                     ": the recording used as the reference has changed since the study was submitted");
  }
  MergedShards merged = merge_shards(plan, folder, folder.out() / "study.sqlite");
  CasesOutcome outcome;
  outcome.records = std::move(merged.records);
  outcome.declared = std::move(merged.declared);
  outcome.judged = plan.planned.judged;
  outcome.provenance = provenance_of(plan.planned, default_cache_folder());
  outcome.cost.run_cpu_s = merged.run_cpu_s;
  outcome.cost.total_cpu_s = merged.cpu_s;
  Registry registry(default_node_folders());
  const std::vector<std::string> warnings = warnings_of(merged, plan);
  const nlohmann::ordered_json runner{{"tasks", merged.shards},
                                      {"core_hours", merged.core_s / 3600},
                                      {"cpu_hours", merged.cpu_s / 3600},
                                      {"made_twice", merged.twice},
                                      {"unlike_twice", merged.unlike_twice},
                                      {"missing_runs", merged.missing_runs},
                                      {"left_out_runs", merged.left_out},
                                      {"missing_tasks", merged.missing_chunks}};
  const int code = finish_study(plan.spec, plan.planned.cases, std::move(outcome), registry,
                                {.folder = folder.out(),
                                 .seeds = plan.planned.settings.seeds,
                                 .interrupted = "interrupted; the runs are kept, and --resume writes the report",
                                 .warnings = warnings,
                                 .where = where_of(merged, plan),
                                 .runner = runner.dump()});
  const bool is_doubtful = merged.missing_runs > 0 || !merged.unlike_twice.empty();
  return is_doubtful ? std::max(code, 1) : code;
}

/// The merge, with what it prints in a file, and how it ended in another.
int run_merge(ClusterPlan& plan, const ClusterFolder& folder) {
  // What was printed is for whoever waits for the study, on another machine.
  std::fflush(stdout);
  const FileDescriptor table(::open(folder.table().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!table || ::dup2(table.number(), STDOUT_FILENO) < 0) {
    throw RunError("cannot write " + folder.table().string() + ": " + std::strerror(errno));
  }
  nlohmann::ordered_json ended{{"exit_code", 0}, {"message", ""}};
  try {
    ended["exit_code"] = merge_and_report(plan, folder);
  } catch (const InputError& error) {
    ended = {{"exit_code", 2}, {"message", error.what()}};
  } catch (const RunError& error) {
    if (is_interrupted()) throw;
    ended = {{"exit_code", 1}, {"message", std::string("tactor: ") + error.what()}};
  }
  std::fflush(stdout);
  publish_bytes(ended.dump(1) + "\n", folder.merged());
  return ended["exit_code"];
}

}  // namespace

int run_cluster_task(const fs::path& out, std::size_t submission, std::size_t index) {
  const ClusterFolder folder(out);
  ClusterPlan plan = read_plan(folder);
  const Submission mine = read_submission(folder, submission);
  if (index >= mine.chunks.size()) {
    throw InputError(fmt::format("{}: expected an index below {}, the tasks of submission {}, found {}", out.string(),
                                 mine.chunks.size(), submission, index));
  }
  switch (mine.stage) {
    case StageKind::intervals:
      return find_intervals(plan, folder);
    case StageKind::merge:
      return run_merge(plan, folder);
    case StageKind::warm:
    case StageKind::references:
    case StageKind::runs:
      if (mine.stage == StageKind::runs) plan.planned.judged = read_intervals(plan, folder);
      return run_chunk(plan, folder, mine.stage, mine.chunks[index]);
  }
  TACTOR_DEMAND(false);
}

}  // namespace tactor
