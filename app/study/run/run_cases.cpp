#include "app/study/run/run_cases.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "app/output.hpp"
#include "app/run/cpu_time.hpp"
#include "app/run/references.hpp"
#include "app/run/timing.hpp"
#include "app/statistics.hpp"
#include "app/study/run/crash_board.hpp"
#include "app/study/run/supervisor.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/engine/reference.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Seconds for which this thread was ready to run and had no core; 0 where the kernel does not tell.
double waited_for_core() {
  std::ifstream file("/proc/thread-self/schedstat");
  double ran_ns = 0, waited_ns = 0;
  file >> ran_ns >> waited_ns;
  return 1e-9 * waited_ns;
}

/// Runs `work(i)` for i in [0, count) on `jobs` threads until it says no; the first exception is thrown again. Adds up
/// what the threads waited for a core in `waited_s`.
template <class Work>
void in_parallel(std::size_t count, unsigned jobs, double& waited_s, const Work& work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto loop = [&] {
    const CrashStack stack;
    const double waited = waited_for_core();
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        if (!work(i)) next = count;
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
    const std::lock_guard lock(mutex);
    waited_s += waited_for_core() - waited;
  };
  std::vector<std::thread> threads;
  try {
    for (unsigned t = 1; t < std::min<std::size_t>(jobs, count); ++t) threads.push_back(make_thread("study", loop));
    loop();
  } catch (const RunError&) {
    const std::lock_guard lock(mutex);
    if (!failure) failure = std::current_exception();
    next = count;
  }
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

std::vector<double> each(const std::vector<RunResult>& runs, double RunResult::*value) {
  std::vector<double> values;
  for (const RunResult& run : runs) values.push_back(run.*value);
  return values;
}

/// The first of runs that differ in nothing but their run times, with the medians of these.
RunResult merged(std::vector<RunResult> runs) {
  const double cpu = median(each(runs, &RunResult::cpu_s));
  const double wall = median(each(runs, &RunResult::wall_s));
  RunResult result = std::move(runs.front());
  if (runs.size() == 1) return result;
  result.cpu_s = cpu;
  result.wall_s = wall;
  for (std::size_t n = 0; n < result.nodes.size(); ++n) {
    for (double NodeCost::*value : {&NodeCost::median_us, &NodeCost::p99_us, &NodeCost::total_s}) {
      std::vector<double> values{result.nodes[n].*value};
      for (std::size_t r = 1; r < runs.size(); ++r) values.push_back(runs[r].nodes[n].*value);
      result.nodes[n].*value = median(values);
    }
  }
  return result;
}

/// The name of a metric in which two runs of the same graph and seed differ; empty where there is none.
std::string first_difference(const RunResult& a, const RunResult& b) {
  if (a.metrics.size() != b.metrics.size()) return "the number of metrics";
  for (std::size_t i = 0; i < a.metrics.size(); ++i) {
    const auto& [name, value] = a.metrics[i];
    const bool same = value == b.metrics[i].second || (std::isnan(value) && std::isnan(b.metrics[i].second));
    if (name != b.metrics[i].first || !same) return name;
  }
  return {};
}

/// Runs cases; one object a call of run_cases.
class StudyRunner {
 public:
  StudyRunner(const std::vector<RunCase>& cases, Registry& registry, const CasesOptions& options)
      : cases_(cases),
        registry_(registry),
        options_(options),
        board_(options.supervisor != nullptr ? &options.supervisor->board() : nullptr),
        begun_(board_ != nullptr && board_->has_table()) {
    if (board_ != nullptr && options.run_timeout_s) board_->set_timeout(*options.run_timeout_s);
  }

  CasesOutcome run() {
    const CrashSignals signals(board_);
    tell_of_crash();
    const std::size_t made_before = board_ != nullptr ? board_->rows() : 0;
    plan_all();
    TableIdentity identity = options_.identity;
    if (!begun_) identity.program = program_hash();
    make_folder(options_.table.parent_path());
    RunTable table(options_.table, begun_ ? TableMode::go_on : options_.mode, identity, names());
    if (options_.mode == TableMode::resume && !begun_ && table.is_new()) {
      note(fmt::format("--resume: {} held no runs to go on with; they begin anew", options_.table.string()));
    }
    if (board_ != nullptr) board_->set_has_table();
    const std::vector<bool> finished = table.finished();
    const Pending pending = sorted_out(finished, table);
    CasesOutcome outcome;
    outcome.found = static_cast<std::size_t>(std::count(finished.begin(), finished.end(), true)) - made_before;
    outcome.crashes = options_.supervisor != nullptr ? options_.supervisor->crashes() : 0;
    const double wall = clock_seconds(CLOCK_MONOTONIC);
    const double cpu = clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
    done_ = 0;
    all_ = pending.suspects.size() + pending.others.size();
    try_alone(pending.suspects, table);
    run_all(pending.others, options_.reference_jobs, options_.jobs, table);
    outcome.cost = {clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu, run_cpu_s_, reference_cpu_s_, waited_for_core_s_,
                    clock_seconds(CLOCK_MONOTONIC) - wall};
    outcome.records = table.read();
    outcome.declared = table.declared();
    outcome.interrupted = outcome.records.size() < finished.size();
    if (options_.progress && !outcome.interrupted) options_.progress(1.0, "done");
    for (RunRecord& record : outcome.records) {
      record.result.graph = graph_name(record.number / seeds());
      record.result.seed = options_.seeds[record.number % seeds()];
    }
    return outcome;
  }

 private:
  /// What a case is planned to, once for all seeds.
  struct Planned {
    std::optional<Plan> plan;       // none where it is refused, or crashes the process
    std::optional<Plan> reference;  // of the graph that judges it, where that is another
    RunStatus status = RunStatus::refused;
    std::string message;      // why there is no plan
    bool may_differ = false;  // next time
    std::string content;
    std::exception_ptr why;
  };

  /// The runs that are to be made.
  struct Pending {
    std::vector<std::size_t> suspects;  // a process crashed in them: one at a time, before the others
    std::vector<std::size_t> others;
  };

  /// Says what the process before this one ended in.
  void tell_of_crash() {
    if (options_.supervisor == nullptr || !options_.supervisor->last()) return;
    const Crash& crash = *options_.supervisor->last();
    std::vector<std::string> names;
    for (const RunPlace& place : crash.places) names.push_back(name_of(place));
    const char* const next = crash.is_last              ? "it has failed, and the others go on"
                             : crash.places.size() == 1 ? "it is tried once more, alone"
                                                        : "each is tried once more, alone";
    if (names.empty()) {
      note(fmt::format("between two runs: {}; they go on", crash.ending.text));
    } else {
      note(fmt::format("{}: {}; {}", fmt::join(names, ", or "), crash.ending.text, next));
    }
  }

  [[nodiscard]] std::string name_of(RunPlace place) const {
    if (place.stage != RunStage::planning) {
      return (place.stage == RunStage::reference ? "the reference run of " : "") + name_of(place.number);
    }
    return "the planning of " + case_name(graph_name(place.number), cases_[place.number].configuration);
  }

  /// Adds runs that are given up to the table as failed, and sorts the others that are not there.
  Pending sorted_out(const std::vector<bool>& finished, RunTable& table) const {
    std::vector<bool> pending = finished;
    pending.flip();
    Pending sorted;
    if (options_.supervisor != nullptr) {
      add_lost(pending, table);
      for (const RunPlace& place : options_.supervisor->suspects()) {
        if (place.stage == RunStage::planning || !pending[place.number]) continue;
        pending[place.number] = false;
        sorted.suspects.push_back(place.number);
      }
    }
    for (std::size_t run = 0; run < pending.size(); ++run) {
      if (pending[run]) sorted.others.push_back(run);
    }
    return sorted;
  }

  /// A run is given up where it crashed a process, and where the reference run did that it needs.
  void add_lost(std::vector<bool>& pending, RunTable& table) const {
    std::map<std::string, Ending> endings;  // of reference runs
    for (const auto& [place, ending] : options_.supervisor->lost()) {
      if (place.stage != RunStage::reference || !planned_[place.number / seeds()].plan) continue;
      endings.emplace(reference_of(place.number), ending);
    }
    for (std::size_t run = 0; run < pending.size(); ++run) {
      if (!pending[run] || !planned_[run / seeds()].plan) continue;
      RunRecord record;
      const auto own = options_.supervisor->lost().find({RunStage::run, run});
      if (own != options_.supervisor->lost().end()) {
        record.message = lost_message(own->second);
        record.may_differ = own->second.may_differ;
      } else if (const auto other = endings.empty() ? endings.end() : endings.find(reference_of(run));
                 other != endings.end()) {
        record.message = "the reference run that this run needs was " + lost_message(other->second);
        record.may_differ = other->second.may_differ;
      } else {
        continue;
      }
      record.number = run;
      record.status = RunStatus::failed;
      record.result.title = planned_[run / seeds()].plan->graph.title;
      add(record, table);
      pending[run] = false;
    }
  }

  static std::string lost_message(const Ending& ending) {
    return "tried twice, the second time with no other run beside it: " + ending.text;
  }

  void add(const RunRecord& record, RunTable& table) const {
    table.add(record);
    if (board_ != nullptr) board_->count_row();
  }

  /// What tells the reference run that a run needs from others; empty where it needs none.
  [[nodiscard]] std::string reference_of(std::size_t run) const {
    const std::optional<Plan> other = reference_for(run);
    return reference_id(other ? *other : plan_for(run));
  }

  /// One after the other, and the first one as the first of the process.
  void try_alone(const std::vector<std::size_t>& runs, RunTable& table) {
    for (const std::size_t run : runs) {
      if (board_ != nullptr) board_->set_trial(run == runs.front() ? std::optional(run) : std::nullopt);
      run_all({run}, 1, 1, table);
    }
    if (board_ != nullptr) board_->set_trial(std::nullopt);
  }

  void run_all(const std::vector<std::size_t>& runs, unsigned reference_jobs, unsigned jobs, RunTable& table) {
    if (!options_.without_reference) make_references(runs, reference_jobs);
    run_pending(runs, jobs, table);
  }

  [[nodiscard]] std::size_t seeds() const { return options_.seeds.size(); }
  [[nodiscard]] std::string graph_name(std::size_t c) const { return tactor::graph_name(cases_[c].graph); }
  [[nodiscard]] std::string name_of(std::size_t run) const {
    const std::size_t c = run / seeds();
    return run_name(graph_name(c), cases_[c].configuration, options_.seeds[run % seeds()]);
  }

  /// The seed decides nothing but `graph.seed`, so that one plan serves all seeds.
  Plan plan_of(const fs::path& graph, Overrides overrides) {
    overrides.push_back(option_patch("--seed", "seed", std::to_string(options_.seeds.front())));
    return make_plan(load_graph(graph, registry_, overrides));
  }

  /// The cases that have runs to be made: first what crashed a process while it was planned, so that nothing before it
  /// can be to blame.
  [[nodiscard]] std::vector<std::size_t> to_be_planned() const {
    std::vector<bool> left(cases_.size(), !begun_);
    if (begun_) {
      const std::vector<bool> finished = RunTable::finished_in(options_.table);
      for (std::size_t run = 0; run < finished.size(); ++run) {
        if (!finished[run]) left[run / seeds()] = true;
      }
    }
    std::vector<std::size_t> order;
    const auto take = [&](std::size_t c) {
      if (left[c]) order.push_back(c);
      left[c] = false;
    };
    if (options_.supervisor != nullptr) {
      for (const RunPlace& place : options_.supervisor->suspects()) {
        if (place.stage == RunStage::planning) take(place.number);
      }
    }
    for (std::size_t c = 0; c < cases_.size(); ++c) take(c);
    return order;
  }

  void plan_all() {
    planned_.resize(cases_.size());
    std::size_t refused = 0;
    NodeChecks checks;
    for (const std::size_t c : to_be_planned()) {
      if (!go_on()) throw RunError("interrupted while the graphs were read; runs that had finished are kept");
      Planned& planned = planned_[c];
      if (lost_in_planning(c)) continue;
      const CrashPlace place(board_, {RunStage::planning, c});
      try {
        planned.plan = plan_of(cases_[c].graph, cases_[c].overrides);
        if (planned.plan->graph.clock == Clock::real) {
          throw InputError(cases_[c].graph.string() +
                           ": clock: real: expected clock: virtual, under which all pipelines meet the same "
                           "conditions; add --set clock=virtual");
        }
        for (const std::string& text : checks.check(*planned.plan)) {
          if (!begun_) note(text);  // else a process before this one has said it
        }
        if (cases_[c].reference) {
          planned.reference = plan_of(cases_[c].graph, *cases_[c].reference);
          checks.check(*planned.reference);
        }
        planned.content = content_of(planned);
      } catch (const InputError& error) {
        refuse(planned, error.what(), std::current_exception());
      }
      if (!planned.why) continue;
      ++refused;
      if (!options_.refused_are_results) std::rethrow_exception(planned.why);
    }
    if (refused == cases_.size() && refused > 0) std::rethrow_exception(planned_.front().why);
    // A process that goes on after a crash plans some cases alone; the one before it has asked.
    if (!begun_ && options_.planned) options_.planned(metrics_of_all());
  }

  [[nodiscard]] RunMetrics metrics_of_all() const {
    RunMetrics metrics;
    for (const Planned& planned : planned_) {
      if (!planned.plan) continue;
      metrics.add(run_metrics(*planned.plan, !options_.without_reference));
      metrics.add(run_times(*planned.plan));
    }
    return metrics;
  }

  /// Whether it is given up, because its planning crashed a process.
  bool lost_in_planning(std::size_t c) {
    if (options_.supervisor == nullptr) return false;
    const auto found = options_.supervisor->lost().find({RunStage::planning, c});
    if (found == options_.supervisor->lost().end()) return false;
    planned_[c].status = RunStatus::failed;
    planned_[c].message = "its planning was " + lost_message(found->second);
    planned_[c].may_differ = found->second.may_differ;
    return true;
  }

  static void refuse(Planned& planned, std::string text, std::exception_ptr why) {
    planned.plan.reset();
    planned.message = std::move(text);
    planned.why = std::move(why);
    planned.content = content_key({"refused", planned.message});
  }

  static std::string content_of(const Planned& planned) {
    const std::string own = reference_key(*planned.plan, {});
    if (!planned.reference) return content_key({to_yaml(planned.plan->graph), own});
    return content_key(
        {to_yaml(planned.plan->graph), own, to_yaml(planned.reference->graph), reference_key(*planned.reference, {})});
  }

  [[nodiscard]] std::vector<RunName> names() const {
    std::vector<RunName> names;
    for (std::size_t c = 0; c < cases_.size(); ++c) {
      for (const std::uint64_t seed : options_.seeds) {
        names.push_back({graph_name(c), cases_[c].configuration, seed, planned_[c].content});
      }
    }
    return names;
  }

  void note(const std::string& text) {
    const std::lock_guard lock(notes_);
    if (options_.note) options_.note(text);
  }

  /// False where the user has had enough.
  bool go_on() const { return !stopped_ && (!options_.interrupted || !options_.interrupted()); }

  void tell(std::size_t done, std::size_t all, const std::string& what) {
    const std::lock_guard lock(progress_);
    const double share = static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(1, all));
    if (options_.progress && !options_.progress(share, what)) stopped_ = true;
  }

  /// The plan of a run, for its own seed.
  Plan plan_for(std::size_t run) const {
    Plan plan = *planned_[run / seeds()].plan;
    plan.graph.seed = options_.seeds[run % seeds()];
    return plan;
  }
  std::optional<Plan> reference_for(std::size_t run) const {
    std::optional<Plan> plan = planned_[run / seeds()].reference;
    if (plan) plan->graph.seed = options_.seeds[run % seeds()];
    return plan;
  }

  /// Runs that differ in what comes after physics share a reference, so each is made once, before the runs ask for it.
  void make_references(const std::vector<std::size_t>& runs, unsigned jobs) {
    std::set<std::string> seen;
    std::vector<std::size_t> first_uses;
    std::mutex mutex;
    in_parallel(runs.size(), jobs, waited_for_core_s_, [&](std::size_t i) {
      const std::size_t run = runs[i];
      if (!go_on()) return false;
      if (!planned_[run / seeds()].plan) return true;
      const std::string key = reference_of(run);
      const std::lock_guard lock(mutex);
      if (!key.empty() && seen.insert(key).second) first_uses.push_back(run);
      return true;
    });
    std::sort(first_uses.begin(), first_uses.end());
    std::atomic<std::size_t> done{0};
    in_parallel(first_uses.size(), jobs, waited_for_core_s_, [&](std::size_t i) {
      if (!go_on()) return false;
      const std::size_t run = first_uses[i];
      tell(done++, first_uses.size(), "reference runs");
      const double cpu = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
      const CrashPlace place(board_, {RunStage::reference, run});
      try {
        const Plan plan = plan_for(run);
        const std::optional<Plan> other = reference_for(run);
        static_cast<void>(prepare_reference(
            plan, other ? &*other : nullptr,
            {options_.cache_folder, [this](double) { return go_on(); }, [this](const std::string& n) { note(n); }}));
      } catch (const std::exception&) {
        // The run that needs it meets the same and keeps the message.
      }
      const std::lock_guard lock(mutex);
      reference_cpu_s_ += clock_seconds(CLOCK_THREAD_CPUTIME_ID) - cpu;
      return true;
    });
  }

  void run_pending(std::vector<std::size_t> runs, unsigned jobs, RunTable& table) {
    // Seeds outside and cases inside: a machine that slows down for a while does so for all methods alike.
    std::sort(runs.begin(), runs.end(), [this](std::size_t a, std::size_t b) {
      return std::pair(a % seeds(), a / seeds()) < std::pair(b % seeds(), b / seeds());
    });
    std::mutex mutex;
    in_parallel(runs.size(), jobs, waited_for_core_s_, [&](std::size_t i) {
      if (!go_on()) return false;
      {
        const std::size_t c = runs[i] / seeds();
        const std::lock_guard lock(mutex);
        tell(done_, all_, graph_name(c) + " " + cases_[c].configuration);
      }
      CrashPlace place(board_, {RunStage::run, runs[i]});
      const double control = measure_control();
      const double cpu = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
      std::optional<RunRecord> record = run_one(runs[i], place);
      place.end();
      if (!record) return false;
      record->control_us = control;
      const std::lock_guard lock(mutex);
      run_cpu_s_ += clock_seconds(CLOCK_THREAD_CPUTIME_ID) - cpu;
      add(*record, table);
      tell(++done_, all_, "runs");
      return true;
    });
  }

  /// Nothing where it was interrupted.
  std::optional<RunRecord> run_one(std::size_t run, CrashPlace& place) {
    const Planned& planned = planned_[run / seeds()];
    RunRecord record;
    record.number = run;
    if (!planned.plan) {
      record.status = planned.status;
      record.message = planned.message;
      record.may_differ = planned.may_differ;
      return record;
    }
    try {
      std::vector<RunResult> results;
      const Plan plan = plan_for(run);
      const std::optional<Plan> reference = reference_for(run);
      for (std::int64_t r = -options_.warm_up; r < options_.repeats; ++r) {
        place.begin();
        const double began = clock_seconds(CLOCK_MONOTONIC);
        RunResult result = execute_once(plan, reference);
        if (result.interrupted || result.reference_interrupted) return std::nullopt;
        const double limit = options_.run_timeout_s.value_or(std::numeric_limits<double>::infinity());
        if (clock_seconds(CLOCK_MONOTONIC) - began > limit) {
          record.may_differ = true;
          throw RunError(took_longer(limit));
        }
        if (result.failure) throw RunError(*result.failure);
        if (r < 0) continue;
        if (!results.empty()) {
          const std::string metric = first_difference(results.front(), result);
          if (!metric.empty()) throw RunError("a repeat with the same seed gave another result: " + metric);
          result.series.clear();
        }
        results.push_back(std::move(result));
      }
      record.cpu_s = each(results, &RunResult::cpu_s);
      record.result = merged(std::move(results));
      keep_curves(run, record.result);
    } catch (const InputError& error) {
      record.status = RunStatus::refused;
      record.message = error.what();
    } catch (const std::exception& error) {
      if (!go_on()) return std::nullopt;
      record.status = RunStatus::failed;
      record.message = error.what();
    }
    record.result.title = planned.plan->graph.title;
    return record;
  }

  RunResult execute_once(const Plan& plan, const std::optional<Plan>& reference) {
    RunOptions run_options;
    run_options.cache_folder = options_.cache_folder;
    run_options.note = [this](const std::string& text) { note(text); };
    run_options.progress = [this](double, const char*) { return go_on(); };
    if (reference) run_options.reference = &*reference;
    run_options.without_reference = options_.without_reference;
    return execute(plan, run_options);
  }

  void keep_curves(std::size_t run, RunResult& result) const {
    if (options_.curves && run % seeds() == 0) return;
    std::erase_if(result.series, [](const Series& curve) { return curve.name != "one_step_error"; });
  }

  const std::vector<RunCase>& cases_;
  Registry& registry_;
  const CasesOptions& options_;
  CrashBoard* const board_;  // null where nobody watches
  const bool begun_;         // by a process before this one, which crashed: the table is of this command
  std::vector<Planned> planned_;
  std::size_t done_ = 0, all_ = 0;  // runs to be made
  std::atomic<bool> stopped_ = false;
  std::mutex notes_, progress_;
  double run_cpu_s_ = 0;
  double reference_cpu_s_ = 0;
  double waited_for_core_s_ = 0;
};

}  // namespace

CasesOutcome run_cases(const std::vector<RunCase>& cases, Registry& registry, const CasesOptions& options) {
  return StudyRunner(cases, registry, options).run();
}

}  // namespace tactor
