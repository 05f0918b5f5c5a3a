#include "app/study/cluster/cluster_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/results_folder.hpp"
#include "app/run/references.hpp"
#include "app/study/cluster/cluster_plan.hpp"
#include "app/study/cluster/cluster_system.hpp"
#include "app/study/cluster/earlier_study.hpp"
#include "app/study/cluster/intervals.hpp"
#include "app/study/cluster/measure.hpp"
#include "app/study/cluster/own_files.hpp"
#include "app/study/cluster/progress.hpp"
#include "app/study/cluster/submission.hpp"
#include "app/study/cluster/submit.hpp"
#include "app/study/report/stability_map.hpp"
#include "app/study/run/study_metrics.hpp"
#include "app/study/run/study_worker.hpp"
#include "app/study/run/worker_pool.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// A study that has been handed over, read back.
struct HandedOver {
  ClusterFolder folder;
  ClusterPlan plan;
  ClusterOptions options;
  ClusterSystem system;

  explicit HandedOver(const fs::path& out)
      : folder(out),
        plan(read_plan(folder)),
        options(read_options(folder)),
        system(load_cluster_system(options.system)) {}
  [[nodiscard]] ClusterProgress progress() const {
    return find_progress(plan, folder, ask_for_jobs(system, jobs_of(read_submissions(folder))));
  }
};

/// Throws InputError where tasks of the study in this folder wait or run, or may.
void refuse_while_alive(const fs::path& out, const ClusterFolder& folder, const ClusterOptions& options) {
  const ClusterSystem system = load_cluster_system(options.system);
  std::vector<Submission> submissions = read_submissions(folder);
  // A merge that has written all it had to may take a moment to end.
  std::error_code ignored;
  if (fs::exists(folder.merged(), ignored)) {
    std::erase_if(submissions, [](const Submission& one) { return one.stage == StageKind::merge; });
  }
  for (const auto& [job, counts] : ask_for_jobs(system, jobs_of(submissions))) {
    if (counts.waiting + counts.running == 0) continue;
    throw InputError(
        fmt::format("{}: expected a study of which nothing runs, found job {} on {}; tactor study {} --wait "
                    "waits for it, --cancel ends it",
                    out.string(), job, system.title, as_typed(out.string())));
  }
}

FileLock lock_of(const fs::path& out) {
  return {out / "cluster.lock", fmt::format("--out {}: expected a folder", out.string())};
}

}  // namespace

void refuse_study_folder(const fs::path& out, bool overwrite) {
  const ClusterFolder folder(out);
  const bool has_table = is_taken(out / "study.sqlite");
  if (!has_table && !folder.is_there()) return;
  if (!overwrite) {
    throw InputError(
        fmt::format("--out {}: expected no study there yet, found {}; {}--overwrite begins anew", out.string(),
                    folder.is_there() ? "one that was handed to a cluster" : "the runs of one",
                    folder.is_there() ? fmt::format("tactor study {} --resume continues it, ", as_typed(out.string()))
                                      : std::string()));
  }
  if (!folder.is_there()) return;
  demand_own(folder);
  std::optional<ClusterOptions> options;
  try {
    options = read_options(folder);
  } catch (const InputError& error) {
    tell_note(fmt::format("{}; whether it still runs is not known", error.what()));
  }
  if (options) refuse_while_alive(out, folder, *options);
}

namespace {

std::size_t tasks_of(const std::vector<Submission>& submissions, StageKind stage) {
  std::size_t tasks = 0;
  for (const Submission& one : submissions) tasks += one.stage == stage ? one.chunks.size() : 0;
  return tasks;
}

void tell_submitted(const ClusterPlan& plan, const ClusterFolder& folder, const ClusterSystem& system,
                    const std::vector<Submission>& submissions) {
  std::string tasks;
  for (const StageKind stage : all_stages) {
    const std::size_t count = tasks_of(submissions, stage);
    if (count > 0) tasks += fmt::format("{}{} {}", tasks.empty() ? "" : ", ", count, name_of(stage));
  }
  if (submissions.size() == 1) {
    fmt::print("{}: none of its {} runs is missing; they are merged again\n", plan.spec.name, plan.planned.runs());
  } else {
    fmt::print("{}: {} runs, handed to {}; tasks: {}\n", plan.spec.name, plan.planned.runs(), system.title, tasks);
  }
  fmt::print("  jobs {}\n", fmt::join(jobs_of(submissions), " "));
  fmt::print("  tactor study {0} --status shows its progress; --wait, --cancel and --resume work on it too\n",
             as_typed(folder.out().string()));
  if (plan.spec.repeats > 1 && !plan.exclusive) {
    fmt::print("  its run times come from nodes shared with other programs; --exclusive asks for exclusive nodes\n");
  }
  std::fflush(stdout);
}

}  // namespace

bool is_cluster_study(const fs::path& out) {
  return ClusterFolder(out).is_there();
}

int run_study_on_cluster(const StudyRequest& request, const ClusterRequest& cluster) {
  PreparedStudy study = prepare_study(request);
  const ClusterSystem system = load_cluster_system(cluster.system);
  const fs::path out = fs::absolute(study.folder).lexically_normal();
  const ClusterFolder folder(out);
  check_job_scripts(study.spec, out);
  demand_own(folder);
  // A cluster that does not answer is to be known before anything is measured.
  static_cast<void>(most_tasks_of_array(system));
  make_own_folder(out);
  const FileLock lock = lock_of(out);
  refuse_study_folder(out, request.overwrite);
  Registry registry(default_node_folders());
  if (study.spec.report == StudyReport::stability && !study.spec.record.empty()) {
    check_record(study.spec, study.cases, registry);
  }
  ClusterPlan plan;
  {
    ProgressBar bar;
    const auto note = once([&bar](const std::string& text) {
      bar.clear();
      tell_note(text);
    });
    StudyWorker worker(registry);
    WorkerPool pool([&](const std::string& job, const PoolLink& link) { return worker.do_job(job, link); },
                    [] { return interruption.load(); });
    make_own_folder(folder.path());
    plan.planned = plan_cases(
        study.cases, study.settings, pool, folder.cache(), request.jobs,
        {.note = note, .planned = [&](const RunMetrics& metrics) { check_metrics(study.spec, metrics, registry); }});
    Measured measured = measure_costs(
        plan.planned, pool, folder.cache(), request.jobs,
        [&bar](double share, const std::string& what) { bar.draw(share, what); }, note);
    plan.costs = std::move(measured.costs);
    plan.depends_on_processor = std::move(measured.depends_on_processor);
  }
  for (const std::optional<Obstacle>& obstacle : plan.planned.obstacles) {
    if (obstacle && obstacle->may_differ) throw RunError(obstacle->message + "; nothing was submitted");
  }
  if (!plan.depends_on_processor.empty()) {
    tell_note(
        fmt::format("last digits depend on the processor: {}; let all tasks run on one kind of node, such as by "
                    "--sbatch-option --constraint=NAME",
                    fmt::join(plan.depends_on_processor, ", ")));
  }
  if (!study.spec.reference_recording.empty()) {
    for (std::size_t run = 0; run < plan.planned.runs(); ++run) {
      plan.recordings.push_back(plan.planned.recording_hash(run));
    }
  }
  plan.spec = study.spec;
  plan.code = code_hashes(plan.planned.code_files);
  plan.chunk_s = cluster.chunk_s;
  plan.exclusive = cluster.exclusive;
  cut_into_stages(plan);
  ClusterOptions options{system.file,
                         cluster.partition.value_or(""),
                         cluster.account.value_or(""),
                         cluster.time_s.value_or(0),
                         cluster.options,
                         request.jobs};
  std::vector<Submission> submitted;
  {
    EarlierStudy earlier(out);
    write_options(folder, options);
    write_plan(plan, folder);
    submitted = submit_missing(plan, folder, system, options);
    earlier.drop();
  }
  tell_submitted(plan, folder, system, submitted);
  return cluster.wait ? wait_for_cluster_study(out) : 0;
}

int show_cluster_status(const fs::path& out) {
  const HandedOver study(out);
  fmt::print("{}", progress_text(study.plan, study.folder, study.progress(), study.system.title));
  return 0;
}

int cancel_cluster_study(const fs::path& out) {
  const HandedOver study(out);
  std::vector<std::string> alive;
  for (const auto& [job, counts] : ask_for_jobs(study.system, jobs_of(read_submissions(study.folder)))) {
    if (counts.waiting + counts.running > 0) alive.push_back(job);
  }
  cancel_jobs(study.system, alive);
  fmt::print("{}\n", alive.empty()
                         ? std::string("nothing waits or runs any more")
                         : fmt::format("cancelled jobs {}; finished results are kept", fmt::join(alive, " ")));
  return 0;
}

int resume_cluster_study(const fs::path& out, const StudyRequest& request, const ClusterRequest& cluster) {
  const fs::path whole = fs::absolute(out).lexically_normal();
  demand_own(ClusterFolder(whole));
  const FileLock lock = lock_of(whole);
  HandedOver study(whole);
  if (!is_cluster_study(request.file)) {
    const TableIdentity asked = prepare_study(request).settings.identity;
    const TableIdentity& there = study.plan.planned.settings.identity;
    if (asked.study != there.study || asked.options != there.options) {
      throw InputError(
          fmt::format("--out {}: expected the study as it was handed to the cluster, found other options or "
                      "another study file; --overwrite begins anew",
                      out.string()));
    }
  }
  refuse_while_alive(out, study.folder, study.options);
  if (has_intervals(study.plan, study.folder)) study.plan.planned.judged = read_intervals(study.plan, study.folder);
  if (cluster.partition) study.options.partition = *cluster.partition;
  if (cluster.account) study.options.account = *cluster.account;
  if (cluster.time_s) study.options.time_s = *cluster.time_s;
  if (!cluster.options.empty()) study.options.options = cluster.options;
  write_options(study.folder, study.options);
  forget_what_does_not_count(study.plan, study.folder);
  tell_submitted(study.plan, study.folder, study.system,
                 submit_missing(study.plan, study.folder, study.system, study.options));
  return cluster.wait ? wait_for_cluster_study(whole) : 0;
}

int wait_for_cluster_study(const fs::path& out) {
  using Steady = std::chrono::steady_clock;
  const HandedOver study(out);
  ProgressBar bar;
  ClusterProgress progress;
  auto ask_again = Steady::time_point::min();
  auto answered = Steady::now();
  const auto note = once([&bar](const std::string& text) {
    bar.clear();
    tell_note(text + "; it is asked again");
  });
  std::map<std::string, JobCounts> counts;
  auto lived = Steady::now();
  bool is_silent = false;
  for (;;) {
    // Files are looked at often, which costs the cluster nothing; its scheduler spends a hundredth of its time on this.
    if (const auto began = Steady::now(); began >= ask_again) {
      try {
        counts = ask_for_jobs(study.system, jobs_of(read_submissions(study.folder)));
        answered = Steady::now();
        is_silent = false;
      } catch (const RunError& error) {
        // A scheduler may be away for a while, and its tasks go on.
        if (Steady::now() - answered > std::chrono::minutes(10)) throw;
        note(error.what());
        is_silent = true;
      }
      const auto now = Steady::now();
      ask_again =
          now + std::clamp<Steady::duration>(100 * (now - began), std::chrono::seconds(1), std::chrono::minutes(1));
    }
    progress = find_progress(study.plan, study.folder, counts);
    if (progress.is_merged) break;
    // The merge writes its file just before it ends, and a file system of several machines may show it later.
    if (progress.is_alive || is_silent) lived = Steady::now();
    if (Steady::now() - lived > std::chrono::seconds(30)) break;
    std::size_t running = 0;
    std::size_t held = 0;
    for (const StageProgress& stage : progress.stages) {
      running += stage.running;
      held += stage.held;
    }
    bar.draw(progress.share,
             fmt::format("{} tasks run{}", running, held > 0 ? fmt::format(", {} are held", held) : std::string()));
    for (int i = 0; i < 10; ++i) {
      if (is_interrupted()) throw RunError("stopped waiting; the tasks go on");
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  bar.clear();
  std::ifstream table(study.folder.table(), std::ios::binary);
  fmt::print("{}", std::string(std::istreambuf_iterator<char>(table), {}));
  if (!progress.is_merged) {
    fmt::print("{}", progress_text(study.plan, study.folder, progress, study.system.title));
    throw RunError(out.string() + ": its tasks have ended, and the merge has not made its table");
  }
  if (!progress.merge_said.empty()) tell(progress.merge_said + "\n" + complaints(study.folder));
  return progress.merge_code;
}

}  // namespace tactor
