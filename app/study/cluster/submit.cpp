#include "app/study/cluster/submit.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <set>

#include "app/command_output.hpp"
#include "app/output.hpp"
#include "app/study/cluster/intervals.hpp"
#include "app/study/cluster/merge.hpp"
#include "app/study/cluster/own_files.hpp"
#include "app/study/cluster/shard.hpp"
#include "app/study/run/job_fields.hpp"
#include "framework/core/control_characters.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/text.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_tasks = 1000;      // of an array, so that none is a burden to the scheduler
constexpr double least_limit_s = 1800;        // of a task
constexpr double least_merge_limit_s = 3600;  // of what reads all shards

/// For a scheduler that takes a `%` in the name of a file for a placeholder of its own.
std::string doubled_percents(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '%' ? std::string("%%") : std::string(1, c);
  return out;
}

/// `01:30:00`, which Slurm and PBS read.
std::string clock_time(double seconds) {
  const auto s = static_cast<long>(std::ceil(seconds));
  return fmt::format("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// What a job gets of this environment: not all systems hand it on, and a bundle finds its libraries by it.
std::string exports() {
  std::string text;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view entry = *variable;
    const std::size_t end = entry.find('=');
    if (!(entry.starts_with("TACTOR_") || entry.starts_with("LD_LIBRARY_PATH=")) || end == std::string_view::npos) {
      continue;
    }
    const std::string name(entry.substr(0, end)), what = "the environment variable " + with_visible_controls(name);
    if (!is_variable_name(name)) {
      throw InputError(what + ": expected a name of letters, digits and _, because jobs get it; env -u takes it out");
    }
    text += fmt::format("export {}={}\n", name, shell_word(std::string(entry.substr(end + 1)), what));
  }
  return text;
}

/// It names program and folder by whole paths, which are the same on all nodes.
std::string task_command(const fs::path& out) {
  return fmt::format("exec {} task {}", shell_word(fs::read_symlink("/proc/self/exe").string(), "the program's path"),
                     shell_word(fs::absolute(out).string(), "--out"));
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
    tell_unknown_options();
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
  /// What was asked for and the system has no word for.
  void tell_unknown_options() const {
    const auto knows = [this](const std::string& placeholder) {
      return std::any_of(system_.submit.begin(), system_.submit.end(),
                         [&](const std::string& word) { return word.find(placeholder) != std::string::npos; });
    };
    const auto tell = [&](bool is_given, const std::string& placeholder, const char* option) {
      if (is_given && !knows(placeholder)) {
        tell_note(fmt::format("{}: there is no {}, so it is left out", system_.title, option));
      }
    };
    tell(!options_.partition.empty(), "{partition}", "--partition");
    tell(!options_.account.empty(), "{account}", "--account");
    tell(!options_.options.empty(), "{options}", "--sbatch-option");
    tell(plan_.exclusive, "{exclusive}", "--exclusive");
    if (options_.time_s > 0 && !knows("{minutes}")) tell(true, "{time}", "--time");
  }

  void submit_stages() {
    std::vector<std::string> before_runs = submit_chunks(StageKind::references, {});
    if (!has_intervals(plan_, folder_)) {
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
    std::vector<std::size_t> chunks = missing_chunks(plan_, folder_, *stage);
    if (kind == StageKind::runs && !has_intervals(plan_, folder_)) {
      // Which shards are of the intervals that will be found is not known; tasks look, and are done at once.
      chunks.resize(stage->chunks());
      std::iota(chunks.begin(), chunks.end(), std::size_t{0});
    }
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
                    {"log_pattern", doubled_percents(script.string() + ".log")},
                    {"first", "0"},
                    {"last", std::to_string(submission.chunks.size() - 1)},
                    {"array", submission.chunks.size() > 1 ? fmt::format("0-{}", submission.chunks.size() - 1) : ""},
                    {"time", clock_time(limit_s(kind))},
                    {"minutes", std::to_string(static_cast<long>(std::ceil(limit_s(kind) / 60)))},
                    {"partition", options_.partition},
                    {"account", options_.account},
                    {"exclusive", plan_.exclusive && kind == StageKind::runs ? system_.exclusive : ""},
                    {"at_once", std::to_string(options_.at_once)},
                    {"here", system_.folder.string()}};
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

  /// What the nodes start.
  [[nodiscard]] fs::path write_script(const Submission& submission) const {
    const std::string text = fmt::format(
        "#!/bin/sh\n# Tasks of the stage {} of the study {}, written by tactor study.\n{}{} {} \"${{{}:-0}}\"\n",
        name_of(submission.stage), plan_.spec.name, exports(), task_command(folder_.out()), submission.number,
        system_.index);
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

void check_job_scripts(const StudySpec& study, const fs::path& out) {
  refuse_control_characters(study.name, study.file.string());
  static_cast<void>(exports());
  static_cast<void>(task_command(out));
}

std::vector<Submission> submit_missing(const ClusterPlan& plan, const ClusterFolder& folder,
                                       const ClusterSystem& system, const ClusterOptions& options) {
  check_job_scripts(plan.spec, folder.out());
  std::error_code ignored;
  make_own_folder(folder.jobs());
  make_own_folder(folder.lost_reference(0).parent_path());
  for (const Stage& stage : plan.stages) make_own_folder(folder.shards(stage.kind));
  fs::remove(folder.merged(), ignored);
  fs::remove(folder.table(), ignored);
  return Submitter(plan, folder, system, options).run();
}

std::vector<std::size_t> missing_chunks(const ClusterPlan& plan, const ClusterFolder& folder, const Stage& stage) {
  std::vector<std::size_t> missing;
  for (std::size_t chunk = 0; chunk < stage.chunks(); ++chunk) {
    const std::optional<Shard> shard = read_shard(folder.shard(stage.kind, chunk));
    const bool is_whole =
        shard && shard->complete && shard->head.is_of(plan.shard_key(stage.kind), name_of(stage.kind), chunk);
    if (!is_whole) missing.push_back(chunk);
  }
  return missing;
}

namespace {

/// The shard of a chunk without some of its units, as one that is not whole; its twins go. Where none of them is in it,
/// nothing changes, and the answer is false.
bool take_out(const ClusterPlan& plan, const ClusterFolder& folder, StageKind stage, std::size_t chunk,
              const std::function<bool(const Shard& shard, std::size_t unit, const std::string& answer)>& goes) {
  std::error_code ignored;
  const fs::path whole = folder.shard(stage, chunk), part = folder.part(stage, chunk);
  const bool is_whole = fs::exists(whole, ignored);
  const std::optional<Shard> shard = read_shard(is_whole ? whole : part);
  if (!shard || !shard->head.is_of(plan.shard_key(stage), name_of(stage), chunk)) return false;
  const auto one_goes = [&](const auto& record) { return goes(*shard, record.first, record.second); };
  if (std::none_of(shard->records.begin(), shard->records.end(), one_goes)) return false;
  const TemporaryFolder scratch(folder.path(), "scratch-");
  const fs::path kept = scratch.path() / "kept.shard";
  ShardWriter writer(kept, shard->head);
  for (const auto& record : shard->records) {
    if (!one_goes(record)) writer.add(record.first, record.second);
  }
  writer.spent(shard->cost, shard->depends_on_processor);
  publish_last(kept, part);
  fs::remove(whole, ignored);
  for (const fs::path& twin : folder.twins(stage)) {
    if (folder.is_twin_of(twin, chunk)) fs::remove(twin, ignored);
  }
  return true;
}

/// Calls take_out for all chunks of a stage; true where something went.
bool take_out_of_stage(
    const ClusterPlan& plan, const ClusterFolder& folder, StageKind kind,
    const std::function<bool(const Shard& shard, std::size_t unit, const std::string& answer)>& goes) {
  const Stage* stage = plan.stage(kind);
  bool went = false;
  for (std::size_t chunk = 0; stage != nullptr && chunk < stage->chunks(); ++chunk) {
    went = take_out(plan, folder, kind, chunk, goes) || went;
  }
  return went;
}

/// Reference runs that the machine ended: those that they were made for, by number.
std::set<std::size_t> references_to_make_anew(const ClusterFolder& folder) {
  std::set<std::size_t> runs;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.lost_reference(0).parent_path(), ignored)) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != ".bin" || stem.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::optional<std::string> bytes = read_checked(entry.path());
    if (bytes && !from_bytes<std::pair<std::string, bool>>(*bytes).second) continue;
    runs.insert(std::stoul(stem));
    fs::remove(entry.path(), ignored);
  }
  return runs;
}

}  // namespace

void forget_what_does_not_count(const ClusterPlan& plan, const ClusterFolder& folder) {
  if (const std::set<std::size_t> lost = references_to_make_anew(folder); !lost.empty()) {
    const Stage* stage = plan.stage(StageKind::references);
    take_out_of_stage(plan, folder, StageKind::references, [&](const Shard&, std::size_t unit, const std::string&) {
      return lost.count(plan.run_of(*stage, unit)) > 0;
    });
  }
  const bool warm_again = take_out_of_stage(
      plan, folder, StageKind::warm,
      [](const Shard&, std::size_t, const std::string& answer) { return from_message<WarmUp>(answer).may_differ; });
  // The intervals are found anew, and with other ones no shard of runs counts.
  std::error_code ignored;
  if (warm_again) fs::remove(folder.intervals(), ignored);
  const std::optional<RanOn> processor = counted_processor(plan, folder, nullptr);
  take_out_of_stage(plan, folder, StageKind::runs, [&](const Shard& shard, std::size_t, const std::string& answer) {
    const std::optional<RunRecord> run = from_message<RunAnswer>(answer).record;
    return !run || run->may_differ || !counts_on(processor, shard, *run);
  });
}

}  // namespace tactor
