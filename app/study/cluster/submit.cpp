#include "app/study/cluster/submit.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "app/command_output.hpp"
#include "app/study/cluster/merge.hpp"
#include "app/study/cluster/shard.hpp"
#include "app/study/run/job_fields.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/text.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_tasks = 1000;      // of an array, so that none is a burden to the scheduler
constexpr double least_limit_s = 600;         // of a task
constexpr double least_merge_limit_s = 3600;  // of what reads all shards

/// One word for a shell, whatever is in it.
std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// `01:30:00`, which Slurm and PBS read.
std::string clock_time(double seconds) {
  const auto s = static_cast<long>(std::ceil(seconds));
  return fmt::format("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Submits job by job.
class Submitter {
 public:
  Submitter(const ClusterPlan& plan, const ClusterFolder& folder, const ClusterSystem& system,
            const ClusterOptions& options)
      : plan_(plan),
        folder_(folder),
        system_(system),
        options_(options),
        most_(std::min(most_tasks, most_tasks_of_array(system))),
        next_(read_submissions(folder).size()) {}

  std::vector<Submission> run() {
    try {
      submit_stages();
    } catch (...) {
      try {
        cancel_jobs(system_, jobs_of(submitted_));
      } catch (const RunError&) {
        // What was wrong first is told.
      }
      throw;
    }
    return std::move(submitted_);
  }

 private:
  void submit_stages() {
    std::vector<std::string> before_runs = submit_chunks(StageKind::references, {});
    if (plan_.stage(StageKind::warm) != nullptr && !fs::exists(folder_.intervals())) {
      const std::vector<std::string> warm = submit_chunks(StageKind::warm, {});
      before_runs.push_back(submit(StageKind::intervals, {0}, warm));
    }
    std::vector<std::string> all = submit_chunks(StageKind::runs, before_runs);
    all.insert(all.end(), before_runs.begin(), before_runs.end());
    submit(StageKind::merge, {0}, all);
  }

  std::vector<std::string> submit_chunks(StageKind kind, const std::vector<std::string>& after) {
    const Stage* stage = plan_.stage(kind);
    if (stage == nullptr) return {};
    const std::vector<std::size_t> chunks = missing_chunks(plan_, folder_, *stage);
    std::vector<std::string> jobs;
    for (std::size_t begin = 0; begin < chunks.size(); begin += most_) {
      const auto end = std::min(chunks.size(), begin + most_);
      jobs.push_back(submit(
          kind,
          {chunks.begin() + static_cast<std::ptrdiff_t>(begin), chunks.begin() + static_cast<std::ptrdiff_t>(end)},
          after));
    }
    return jobs;
  }

  std::string submit(StageKind kind, std::vector<std::size_t> chunks, const std::vector<std::string>& after) {
    Submission submission{next_++, kind, std::move(chunks), {}};
    // Its file comes before its tasks, which may begin at once.
    write_submission(folder_, submission);
    TemplateValues values;
    const fs::path script = write_script(submission);
    values.texts = {{"script", script.string()},
                    {"name", fmt::format("{}-{}", plan_.spec.name, name_of(kind))},
                    {"log", script.string() + ".log"},
                    {"first", "0"},
                    {"last", std::to_string(submission.chunks.size() - 1)},
                    {"array", submission.chunks.size() > 1 ? fmt::format("0-{}", submission.chunks.size() - 1) : ""},
                    {"time", clock_time(limit_s(kind))},
                    {"minutes", std::to_string(static_cast<long>(std::ceil(limit_s(kind) / 60)))},
                    {"partition", options_.partition},
                    {"account", options_.account},
                    {"exclusive", plan_.exclusive && kind == StageKind::runs ? system_.exclusive : ""},
                    {"at_once", std::to_string(options_.at_once)},
                    {"here", system_.file.parent_path().string()}};
    values.lists = {{"after", after}, {"options", options_.options}};
    const std::string printed = output_of(filled_in(system_.submit, values, system_.joined_by));
    submission.job = std::string(trimmed(std::string_view(printed).substr(0, printed.find_first_of("; \n"))));
    if (submission.job.empty()) {
      throw RunError(fmt::format("{}: submit: expected its command to print the name of the job, found \"{}\"",
                                 system_.file.string(), trimmed(printed)));
    }
    write_submission(folder_, submission);
    submitted_.push_back(submission);
    return submission.job;
  }

  [[nodiscard]] double limit_s(StageKind kind) const {
    if (options_.time_s > 0) return options_.time_s;
    if (kind == StageKind::merge || kind == StageKind::intervals) return least_merge_limit_s;
    const std::vector<double>& costs = plan_.costs.of(kind);
    const double longest = costs.empty() ? 0 : *std::max_element(costs.begin(), costs.end());
    return std::max(least_limit_s, 5 * std::max(plan_.chunk_s, longest));
  }

  /// What the nodes start. It names program and folder by whole paths, which are the same on all nodes.
  [[nodiscard]] fs::path write_script(const Submission& submission) const {
    std::string text = fmt::format("#!/bin/sh\n# Tasks of the stage {} of the study {}, written by tactor study.\n",
                                   name_of(submission.stage), plan_.spec.name);
    for (char** variable = environ; *variable != nullptr; ++variable) {
      const std::string_view entry = *variable;
      const std::size_t end = entry.find('=');
      // Not all systems hand the environment on, and a bundle finds its libraries by it.
      if (!(entry.starts_with("TACTOR_") || entry.starts_with("LD_LIBRARY_PATH=")) || end == std::string_view::npos) {
        continue;
      }
      text += fmt::format("export {}={}\n", entry.substr(0, end), shell_word(std::string(entry.substr(end + 1))));
    }
    text += fmt::format("exec {} task {} {} \"${{{}:-0}}\"\n", shell_word(fs::read_symlink("/proc/self/exe").string()),
                        shell_word(fs::absolute(folder_.out()).string()), submission.number, system_.index);
    const fs::path script = folder_.jobs() / fmt::format("{:04}.sh", submission.number);
    publish_bytes(text, script);
    fs::permissions(script, fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec);
    return script;
  }

  const ClusterPlan& plan_;
  const ClusterFolder& folder_;
  const ClusterSystem& system_;
  const ClusterOptions& options_;
  std::size_t most_;
  std::size_t next_;
  std::vector<Submission> submitted_;
};

}  // namespace

std::vector<Submission> submit_missing(const ClusterPlan& plan, const ClusterFolder& folder,
                                       const ClusterSystem& system, const ClusterOptions& options) {
  std::error_code ignored;
  fs::create_directories(folder.jobs());
  fs::create_directories(folder.lost_reference(0).parent_path());
  for (const Stage& stage : plan.stages) fs::create_directories(folder.shards(stage.kind));
  fs::remove(folder.merged(), ignored);
  fs::remove(folder.table(), ignored);
  return Submitter(plan, folder, system, options).run();
}

std::vector<std::size_t> missing_chunks(const ClusterPlan& plan, const ClusterFolder& folder, const Stage& stage) {
  std::vector<std::size_t> missing;
  for (std::size_t chunk = 0; chunk < stage.chunks(); ++chunk) {
    const std::optional<Shard> shard = read_shard(folder.shard(stage.kind, chunk));
    const bool is_whole = shard && shard->complete && shard->head.is_of(plan.key, name_of(stage.kind), chunk);
    if (!is_whole) missing.push_back(chunk);
  }
  return missing;
}

void forget_what_does_not_count(const ClusterPlan& plan, const ClusterFolder& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.lost_reference(0).parent_path(), ignored)) {
    fs::remove(entry.path(), ignored);
  }
  const Stage* stage = plan.stage(StageKind::runs);
  const std::optional<RanOn> processor = counted_processor(plan, folder, nullptr);
  const TemporaryFolder scratch;
  for (std::size_t chunk = 0; stage != nullptr && chunk < stage->chunks(); ++chunk) {
    const fs::path whole = folder.shard(StageKind::runs, chunk), part = whole.string() + ".part";
    const bool is_whole = fs::exists(whole, ignored);
    const fs::path& file = is_whole ? whole : part;
    const std::optional<Shard> shard = read_shard(file);
    if (!shard || !shard->head.is_of(plan.key, name_of(StageKind::runs), chunk)) continue;
    const auto does_not_count = [&processor](const auto& record) {
      const std::optional<RunRecord> run = from_message<RunAnswer>(record.second).record;
      return run &&
             (run->may_differ || (processor && !run->ran_on.processor.empty() && !run->ran_on.computes_as(*processor)));
    };
    if (std::none_of(shard->records.begin(), shard->records.end(), does_not_count)) continue;
    const fs::path kept = scratch.path() / "kept.shard";
    fs::remove(kept, ignored);
    ShardWriter writer(kept, shard->head);
    for (const auto& record : shard->records) {
      if (!does_not_count(record)) writer.add(record.first, record.second);
    }
    writer.spent(shard->cost, shard->depends_on_processor);
    publish_last(kept, part);
    if (is_whole) fs::remove(whole, ignored);
  }
}

}  // namespace tactor
