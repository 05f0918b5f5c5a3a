#include "app/study/run/run_cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "app/output.hpp"
#include "app/study/run/planned_cases.hpp"
#include "app/study/run/study_worker.hpp"
#include "app/study/run/worker_pool.hpp"
#include "framework/core/clock.hpp"

namespace tactor {

namespace {

/// Runs cases; one object a call of run_cases. The workers have copies of it, from which they take the registry alone.
class StudyRunner {
 public:
  StudyRunner(const std::vector<RunCase>& cases, Registry& registry, const CasesOptions& options)
      : cases_(cases),
        options_(options),
        worker_(registry),
        pool_([this](const std::string& job, const PoolLink& pool) { return worker_.do_job(job, pool); },
              options.interruptions) {}

  CasesOutcome run() {
    planned_ = plan_cases(cases_, options_, pool_, options_.cache_folder, most_at_once(),
                          {.note = options_.note, .planned = options_.planned});
    find_intervals();
    make_folder(options_.table.parent_path());
    RunTable table(options_.table, options_.mode, planned_.settings.identity, planned_.names());
    if (options_.mode == TableMode::resume && table.is_new()) {
      note(fmt::format("--resume: {} held no runs to continue; the study starts anew", options_.table.string()));
    }
    const std::vector<bool> finished = table.finished();
    CasesOutcome outcome;
    outcome.found = static_cast<std::size_t>(std::count(finished.begin(), finished.end(), true));
    const double wall = clock_seconds(CLOCK_MONOTONIC);
    const double cpu = cpu_of_all();
    make_runs(finished, table);
    outcome.provenance = provenance_of(planned_, options_.cache_folder);
    table.tell(outcome.provenance);
    outcome.cost = cost_;
    outcome.cost.total_cpu_s = cpu_of_all() - cpu;
    outcome.cost.wall_s = clock_seconds(CLOCK_MONOTONIC) - wall;
    outcome.crashes = pool_.lost();
    outcome.records = table.read();
    outcome.declared = table.declared();
    outcome.judged = planned_.judged;
    outcome.interrupted = outcome.records.size() < finished.size();
    if (!outcome.interrupted) tell(1, 1, "done");
    return outcome;
  }

 private:
  [[nodiscard]] unsigned most_at_once() const { return std::max(options_.reference_jobs, options_.jobs); }
  [[nodiscard]] std::size_t seeds() const { return planned_.seeds(); }
  [[nodiscard]] double cpu_of_all() const { return clock_seconds(CLOCK_PROCESS_CPUTIME_ID) + pool_.cpu_s(); }

  void note(const std::string& text) const {
    if (options_.note) options_.note(text);
  }

  void tell_loss(const std::string& what, const Ending& ending) const {
    note(fmt::format("{}: {}; the others go on", what, ending.text));
  }

  void tell(std::size_t done, std::size_t all, const std::string& what) const {
    const double share = static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(1, all));
    if (options_.progress) options_.progress(share, what);
  }

  [[nodiscard]] Job job_of(JobKind kind, std::size_t run) const {
    return planned_.job(kind, run, options_.cache_folder);
  }

  [[nodiscard]] JobBatch batch_of(std::size_t jobs, unsigned at_once) const {
    JobBatch batch;
    batch.jobs = jobs;
    batch.at_once = at_once;
    batch.time_limit_s = options_.run_timeout_s;
    batch.note = [this](const std::string& text) { note(text); };
    return batch;
  }

  /// Finds from when on the nodes of all runs of a group are warm. Throws InputError where one never is, or where too
  /// little is left.
  void find_intervals() {
    std::vector<std::size_t> runs;
    for (std::size_t run = 0; run < planned_.runs(); ++run) {
      if (planned_.has_to_warm_up(run / seeds())) runs.push_back(run);
    }
    std::map<std::size_t, Warmth> warmths;
    JobBatch batch = batch_of(runs.size(), most_at_once());
    batch.job = [&](std::size_t i) {
      tell(i, runs.size(), "when runs are warm");
      return to_message(job_of(JobKind::warm_up, runs[i]));
    };
    batch.done = [&](std::size_t i, const std::string& text) {
      auto answer = from_message<WarmUp>(text);
      cost_.reference_cpu_s += answer.cost.cpu_s;
      cost_.waited_for_core_s += answer.cost.waited_for_core_s;
      // A run that fails before it is warm fails again, and is a row that says so.
      if (answer.failure.empty()) warmths[runs[i]] = std::move(answer.warmth);
      return true;
    };
    batch.lost = [&](std::size_t i, const Ending& ending) {
      tell_loss("the search for when " + planned_.name_of(runs[i]) + " is warm", ending);
    };
    if (!pool_.run(batch)) throw RunError("interrupted before the first run; runs that had finished are kept");
    planned_.judged = judged_intervals(planned_, warmths);
  }

  /// All that the table does not have.
  void make_runs(const std::vector<bool>& finished, RunTable& table) {
    std::vector<std::size_t> runs;
    for (std::size_t run = 0; run < finished.size(); ++run) {
      if (!finished[run]) runs.push_back(run);
    }
    all_ = runs.size();
    // Seeds outside and cases inside: a machine that slows down for a while does so for all methods alike.
    std::sort(runs.begin(), runs.end(), [this](std::size_t a, std::size_t b) {
      return std::pair(a % seeds(), a / seeds()) < std::pair(b % seeds(), b / seeds());
    });
    std::erase_if(runs, [&](std::size_t run) { return add_hopeless(run, planned_.obstacles[run / seeds()], table); });
    if (!make_references(runs)) return;
    std::erase_if(runs, [&](std::size_t run) {
      const auto found = references_.find(reference_of(run));
      return found != references_.end() && add_hopeless(run, found->second, table);
    });
    run_under_test(runs, table);
  }

  /// Where there is an obstacle, adds the run to the table without making it.
  bool add_hopeless(std::size_t run, const std::optional<Obstacle>& obstacle, RunTable& table) {
    if (obstacle) add(planned_.hopeless(run, *obstacle), table);
    return obstacle.has_value();
  }

  void add(const RunRecord& record, RunTable& table) {
    table.add(record);
    tell(++done_, all_, "runs");
  }

  /// The run whose reference run serves this one too.
  [[nodiscard]] std::size_t reference_of(std::size_t run) const {
    return planned_.reference_case[run / seeds()] * seeds() + run % seeds();
  }

  /// Runs that differ in what comes after physics share a reference, so each is made once, before the runs ask for it.
  /// False where it was interrupted.
  bool make_references(const std::vector<std::size_t>& runs) {
    for (const std::size_t run : runs) {
      if (planned_.needs_reference(run / seeds())) references_.emplace(reference_of(run), std::nullopt);
    }
    std::vector<std::size_t> needed;
    for (const auto& [run, obstacle] : references_) needed.push_back(run);
    JobBatch batch = batch_of(needed.size(), options_.reference_jobs);
    batch.job = [&](std::size_t i) {
      tell(i, needed.size(), "reference runs");
      return to_message(job_of(JobKind::reference, needed[i]));
    };
    batch.done = [&](std::size_t, const std::string& answer) {
      const auto cost = from_message<JobCost>(answer);
      cost_.reference_cpu_s += cost.cpu_s;
      cost_.waited_for_core_s += cost.waited_for_core_s;
      return true;
    };
    batch.lost = [&](std::size_t i, const Ending& ending) {
      tell_loss("the reference run of " + planned_.name_of(needed[i]), ending);
      references_.at(needed[i]) = lost_reference(ending);
    };
    return pool_.run(batch);
  }

  void run_under_test(const std::vector<std::size_t>& runs, RunTable& table) {
    JobBatch batch = batch_of(runs.size(), options_.jobs);
    batch.job = [&](std::size_t i) {
      const std::size_t c = runs[i] / seeds();
      tell(done_, all_, planned_.graph_of(c) + " " + cases_[c].configuration);
      Job job = job_of(JobKind::run, runs[i]);
      job.all_curves = options_.curves && runs[i] % seeds() == 0;
      return to_message(job);
    };
    batch.done = [&](std::size_t i, const std::string& text) {
      auto answer = from_message<RunAnswer>(text);
      cost_.run_cpu_s += answer.cost.cpu_s;
      cost_.waited_for_core_s += answer.cost.waited_for_core_s;
      if (answer.record) {
        answer.record->number = runs[i];
        add(*answer.record, table);
      }
      return true;
    };
    batch.lost = [&](std::size_t i, const Ending& ending) {
      tell_loss(planned_.name_of(runs[i]), ending);
      add(planned_.hopeless(runs[i], {RunStatus::failed, ending.text, ending.may_differ}), table);
    };
    static_cast<void>(pool_.run(batch));  // the table tells what is missing
  }

  const std::vector<RunCase>& cases_;
  const CasesOptions& options_;
  StudyWorker worker_;
  WorkerPool pool_;
  PlannedCases planned_;
  std::map<std::size_t, std::optional<Obstacle>> references_;  // needed, by reference_of: what keeps it from being made
  std::size_t done_ = 0, all_ = 0;                             // runs to be made
  CasesCost cost_;
};

}  // namespace

CasesOutcome run_cases(const std::vector<RunCase>& cases, Registry& registry, const CasesOptions& options) {
  return StudyRunner(cases, registry, options).run();
}

}  // namespace tactor
