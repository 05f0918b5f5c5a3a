#include "app/study/run/run_cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "app/output.hpp"
#include "app/run/cpu_time.hpp"
#include "app/run/recorded_reference.hpp"
#include "app/run/references.hpp"
#include "app/study/run/job.hpp"
#include "app/study/run/study_worker.hpp"
#include "app/study/run/worker_pool.hpp"
#include "framework/core/disk_cache.hpp"

namespace tactor {

namespace fs = std::filesystem;

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
    check_cases();
    find_intervals();
    TableIdentity identity = options_.identity;
    identity.program = program_hash(code_files_, codes_);
    make_folder(options_.table.parent_path());
    RunTable table(options_.table, options_.mode, identity, names());
    if (options_.mode == TableMode::resume && table.is_new()) {
      note(fmt::format("--resume: {} held no runs to go on with; they begin anew", options_.table.string()));
    }
    const std::vector<bool> finished = table.finished();
    CasesOutcome outcome;
    outcome.found = static_cast<std::size_t>(std::count(finished.begin(), finished.end(), true));
    const double wall = clock_seconds(CLOCK_MONOTONIC);
    const double cpu = cpu_of_all();
    make_runs(finished, table);
    outcome.cost = cost_;
    outcome.cost.total_cpu_s = cpu_of_all() - cpu;
    outcome.cost.wall_s = clock_seconds(CLOCK_MONOTONIC) - wall;
    outcome.crashes = pool_.lost();
    outcome.records = table.read();
    outcome.declared = table.declared();
    outcome.judged = judged_;
    outcome.interrupted = outcome.records.size() < finished.size();
    if (!outcome.interrupted) tell(1, 1, "done");
    for (RunRecord& record : outcome.records) {
      record.result.graph = graph_name(record.number / seeds());
      record.result.seed = seed_of(record.number);
    }
    return outcome;
  }

 private:
  /// Why a run cannot be made.
  struct Obstacle {
    RunStatus status = RunStatus::failed;
    std::string message;
    bool may_differ = false;  // next time
  };

  [[nodiscard]] std::size_t seeds() const { return options_.seeds.size(); }
  [[nodiscard]] std::uint64_t seed_of(std::size_t run) const { return options_.seeds[run % seeds()]; }
  [[nodiscard]] std::string graph_name(std::size_t c) const { return tactor::graph_name(cases_[c].graph); }
  [[nodiscard]] std::string name_of(std::size_t run) const {
    const std::size_t c = run / seeds();
    return run_name(graph_name(c), cases_[c].configuration, seed_of(run));
  }

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

  [[nodiscard]] Job job_of(JobKind kind, std::size_t c, std::uint64_t seed) const {
    Job job;
    job.kind = kind;
    job.graph = cases_[c].graph;
    job.overrides = cases_[c].overrides;
    job.reference = cases_[c].reference;
    job.seed = seed;
    job.libraries = {libraries_.begin(), libraries_.end()};
    job.repeats = options_.repeats;
    job.warm_up = options_.warm_up;
    job.without_reference = options_.without_reference;
    job.reference_recording = cases_[c].reference_recording;
    if (kind == JobKind::plan && !job.reference_recording.empty()) job.seeds = options_.seeds;
    job.judge_whole = !options_.judge_warm;
    if (options_.judge_warm && kind == JobKind::run) job.judge_from = judged_[cases_[c].group].from;
    job.time_limit_s = options_.run_timeout_s;
    job.cache_folder = options_.cache_folder;
    return job;
  }

  [[nodiscard]] JobBatch batch_of(std::size_t jobs, unsigned at_once) const {
    JobBatch batch;
    batch.jobs = jobs;
    batch.at_once = at_once;
    batch.note = [this](const std::string& text) { note(text); };
    return batch;
  }

  void check_cases() {
    checks_.resize(cases_.size());
    obstacles_.resize(cases_.size());
    JobBatch batch = batch_of(cases_.size(), std::max(options_.reference_jobs, options_.jobs));
    batch.job = [&](std::size_t c) { return to_message(job_of(JobKind::plan, c, options_.seeds.front())); };
    batch.done = [&](std::size_t c, const std::string& answer) {
      checks_[c] = from_message<CaseCheck>(answer);
      return checks_[c].result == CheckResult::planned ||
             (checks_[c].result == CheckResult::refused && options_.refused_are_results);
    };
    batch.lost = [&](std::size_t c, const Ending& ending) {
      tell_loss("the planning of " + case_name(graph_name(c), cases_[c].configuration), ending);
      obstacles_[c] = Obstacle{RunStatus::failed, "its planning: " + ending.text, ending.may_differ};
    };
    if (!pool_.run(batch)) throw RunError("interrupted while the graphs were read; runs that had finished are kept");
    // Jobs end in any order, and what is told of them does not depend on it.
    std::size_t refused = 0;
    RunMetrics metrics;
    for (std::size_t c = 0; c < cases_.size(); ++c) {
      const CaseCheck& check = checks_[c];
      libraries_.insert(check.libraries.begin(), check.libraries.end());
      code_files_.insert(check.code_files.begin(), check.code_files.end());
      codes_.insert(check.codes.begin(), check.codes.end());
      for (const std::string& text : check.notes) note(text);
      if (check.result == CheckResult::failed) throw RunError(check.message);
      if (check.result == CheckResult::refused) {
        if (!options_.refused_are_results) throw InputError(check.message);
        obstacles_[c] = Obstacle{RunStatus::refused, check.message};
        ++refused;
      }
      metrics.add(check.metrics);
    }
    if (refused == cases_.size() && refused > 0) throw InputError(checks_.front().message);
    if (options_.planned) options_.planned(metrics);
  }

  [[nodiscard]] std::vector<RunName> names() const {
    std::vector<RunName> names;
    for (std::size_t c = 0; c < cases_.size(); ++c) {
      for (const std::uint64_t seed : options_.seeds) {
        names.push_back({graph_name(c), cases_[c].configuration, seed, content_of(c, seed)});
      }
    }
    return names;
  }

  /// What a run is, with the interval that it is judged on and the recording that judges it.
  [[nodiscard]] std::string content_of(std::size_t c, std::uint64_t seed) const {
    const Time from = judged_[cases_[c].group].from;
    std::string content = checks_[c].content;
    if (from != Time{}) content = content_key({content, std::to_string(from.ns)});
    if (cases_[c].reference_recording.empty()) return content;
    std::ifstream file(recording_of(cases_[c].reference_recording, graph_name(c), seed), std::ios::binary);
    return content_key({content, std::string(std::istreambuf_iterator<char>(file), {})});
  }

  /// Finds from when on the nodes of all runs of a group are warm. Throws InputError where one never is, or where too
  /// little is left.
  void find_intervals() {
    judged_.resize(1);
    for (const RunCase& c : cases_) judged_.resize(std::max(judged_.size(), c.group + 1));
    if (!options_.judge_warm) {
      for (std::size_t c = 0; c < cases_.size(); ++c) {
        judged_[cases_[c].group].cold = judged_[cases_[c].group].cold || checks_[c].has_to_warm_up;
      }
      return;
    }
    std::vector<std::size_t> runs;
    for (std::size_t run = 0; run < cases_.size() * seeds(); ++run) {
      if (checks_[run / seeds()].has_to_warm_up && !obstacles_[run / seeds()]) runs.push_back(run);
    }
    JobBatch batch = batch_of(runs.size(), std::max(options_.reference_jobs, options_.jobs));
    batch.time_limit_s = options_.run_timeout_s;
    batch.job = [&](std::size_t i) {
      tell(i, runs.size(), "when runs are warm");
      return to_message(job_of(JobKind::warm_up, runs[i] / seeds(), seed_of(runs[i])));
    };
    batch.done = [&](std::size_t i, const std::string& text) {
      const auto answer = from_message<WarmUp>(text);
      cost_.reference_cpu_s += answer.cost.cpu_s;
      cost_.waited_for_core_s += answer.cost.waited_for_core_s;
      // A run that fails before it is warm fails again, and is a row that says so.
      if (answer.failure.empty()) take_warmth(runs[i], answer.warmth);
      return true;
    };
    batch.lost = [&](std::size_t i, const Ending& ending) {
      tell_loss("the search for when " + name_of(runs[i]) + " is warm", ending);
    };
    if (!pool_.run(batch)) throw RunError("interrupted before the first run; runs that had finished are kept");
    if (!never_warm_.empty()) {
      // Jobs end in any order, and what is told of them does not depend on it.
      throw InputError(never_warm_.begin()->second + advice());
    }
    for (std::size_t c = 0; c < cases_.size(); ++c) refuse_too_short(c);
  }

  void take_warmth(std::size_t run, const Warmth& warmth) {
    const double duration = checks_[run / seeds()].duration_s;
    if (!warmth.since) {
      never_warm_[run] = fmt::format("{}: node {} is not warm when the run ends, after {:.6g} s: {}", name_of(run),
                                     warmth.last, duration, warmth.when);
      return;
    }
    JudgedFrom& judged = judged_[cases_[run / seeds()].group];
    if (*warmth.since == Time{}) return;
    const Time from = rounded_up(*warmth.since);
    if (from <= judged.from && (from < judged.from || run > judged.run)) return;
    judged = {from, run, fmt::format("{}: {}", name_of(run), warmth.last), false};
  }

  /// To a tenth of a second, so that a table can name it.
  static Time rounded_up(Time time) {
    constexpr std::int64_t tenth = 100'000'000;
    return Time{(time.ns + tenth - 1) / tenth * tenth};
  }

  static std::string advice() {
    return "; what is compared is judged where all of it is warm: make the runs longer (duration) or what has to fill "
           "shorter, or say `judge: whole` (--judge whole) to judge the cold start too";
  }

  /// A judged interval that is a small rest of the run would say little of it.
  void refuse_too_short(std::size_t c) const {
    constexpr double least_s = 1;
    const JudgedFrom& judged = judged_[cases_[c].group];
    const double duration = checks_[c].duration_s;
    if (judged.from == Time{} || duration - judged.from.seconds() >= least_s || obstacles_[c]) return;
    throw InputError(fmt::format(
        "{}: expected {} s or more of the run after all that it is compared with is warm, "
        "found {:.1f} s: the run lasts {:.6g} s, and {} is warm at {:.6g} s{}",
        case_name(graph_name(c), cases_[c].configuration), least_s, std::max(0.0, duration - judged.from.seconds()),
        duration, judged.last, judged.from.seconds(), advice()));
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
    std::erase_if(runs, [&](std::size_t run) { return add_hopeless(run, obstacles_[run / seeds()], table); });
    if (!make_references(runs)) return;
    std::erase_if(runs, [&](std::size_t run) {
      const auto found = references_.find(reference_of(run));
      return found != references_.end() && add_hopeless(run, found->second, table);
    });
    run_under_test(runs, table);
  }

  /// Where there is an obstacle, adds the run to the table without making it.
  bool add_hopeless(std::size_t run, const std::optional<Obstacle>& obstacle, RunTable& table) {
    if (!obstacle) return false;
    RunRecord record;
    record.status = obstacle->status;
    record.message = obstacle->message;
    record.may_differ = obstacle->may_differ;
    record.result.title = checks_[run / seeds()].title;
    add(run, record, table);
    return true;
  }

  void add(std::size_t run, RunRecord& record, RunTable& table) {
    record.number = run;
    table.add(record);
    tell(++done_, all_, "runs");
  }

  /// What tells the reference run that a run needs from others; its first part is empty where it needs none.
  [[nodiscard]] std::pair<std::string, std::uint64_t> reference_of(std::size_t run) const {
    return {checks_[run / seeds()].reference, seed_of(run)};
  }

  /// Runs that differ in what comes after physics share a reference, so each is made once, before the runs ask for it.
  /// False where it was interrupted.
  bool make_references(const std::vector<std::size_t>& runs) {
    std::vector<std::size_t> first_uses;
    for (const std::size_t run : runs) {
      const auto reference = reference_of(run);
      if (!reference.first.empty() && references_.emplace(reference, std::nullopt).second) first_uses.push_back(run);
    }
    std::sort(first_uses.begin(), first_uses.end());
    JobBatch batch = batch_of(first_uses.size(), options_.reference_jobs);
    batch.time_limit_s = options_.run_timeout_s;
    batch.job = [&](std::size_t i) {
      tell(i, first_uses.size(), "reference runs");
      return to_message(job_of(JobKind::reference, first_uses[i] / seeds(), seed_of(first_uses[i])));
    };
    batch.done = [&](std::size_t, const std::string& answer) {
      const auto cost = from_message<JobCost>(answer);
      cost_.reference_cpu_s += cost.cpu_s;
      cost_.waited_for_core_s += cost.waited_for_core_s;
      return true;
    };
    batch.lost = [&](std::size_t i, const Ending& ending) {
      tell_loss("the reference run of " + name_of(first_uses[i]), ending);
      references_.at(reference_of(first_uses[i])) =
          Obstacle{RunStatus::failed, "the reference run that this run needs: " + ending.text, ending.may_differ};
    };
    return pool_.run(batch);
  }

  void run_under_test(const std::vector<std::size_t>& runs, RunTable& table) {
    JobBatch batch = batch_of(runs.size(), options_.jobs);
    batch.time_limit_s = options_.run_timeout_s;
    batch.job = [&](std::size_t i) {
      const std::size_t c = runs[i] / seeds();
      tell(done_, all_, graph_name(c) + " " + cases_[c].configuration);
      Job job = job_of(JobKind::run, c, seed_of(runs[i]));
      job.all_curves = options_.curves && runs[i] % seeds() == 0;
      return to_message(job);
    };
    batch.done = [&](std::size_t i, const std::string& text) {
      auto answer = from_message<RunAnswer>(text);
      cost_.run_cpu_s += answer.cost.cpu_s;
      cost_.waited_for_core_s += answer.cost.waited_for_core_s;
      if (answer.record) add(runs[i], *answer.record, table);
      return true;
    };
    batch.lost = [&](std::size_t i, const Ending& ending) {
      tell_loss(name_of(runs[i]), ending);
      add_hopeless(runs[i], Obstacle{RunStatus::failed, ending.text, ending.may_differ}, table);
    };
    static_cast<void>(pool_.run(batch));  // the table tells what is missing
  }

  const std::vector<RunCase>& cases_;
  const CasesOptions& options_;
  StudyWorker worker_;
  WorkerPool pool_;
  std::vector<CaseCheck> checks_;                   // by case
  std::vector<std::optional<Obstacle>> obstacles_;  // likewise
  std::set<std::string> libraries_;                 // of nodes, that the cases need
  std::set<fs::path> code_files_;
  std::set<std::string> codes_;  // of nodes in Python
  /// Reference runs that runs need, and what keeps them from being made.
  std::map<std::pair<std::string, std::uint64_t>, std::optional<Obstacle>> references_;
  std::vector<JudgedFrom> judged_;                 // by group
  std::map<std::size_t, std::string> never_warm_;  // by run: what is said of it
  std::size_t done_ = 0, all_ = 0;                 // runs to be made
  CasesCost cost_;
};

}  // namespace

CasesOutcome run_cases(const std::vector<RunCase>& cases, Registry& registry, const CasesOptions& options) {
  return StudyRunner(cases, registry, options).run();
}

}  // namespace tactor
