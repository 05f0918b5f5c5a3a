#include "app/study/run/study_worker.hpp"

#include <fmt/chrono.h>

#include <cmath>
#include <ctime>
#include <exception>
#include <fstream>
#include <limits>
#include <utility>
#include <vector>

#include "app/run/provenance.hpp"
#include "app/run/ran_on.hpp"
#include "app/run/recorded_reference.hpp"
#include "app/run/references.hpp"
#include "app/run/timing.hpp"
#include "app/run/warm_up.hpp"
#include "app/statistics.hpp"
#include "framework/core/clock.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/core/processor_dependence.hpp"
#include "framework/engine/reference.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

/// Seconds for which this thread was ready to run and had no core; 0 where the kernel does not tell.
double waited_for_core() {
  std::ifstream file("/proc/thread-self/schedstat");
  double ran_ns = 0, waited_ns = 0;
  file >> ran_ns >> waited_ns;
  return 1e-9 * waited_ns;
}

/// Adds to a cost what passes while it lives.
class CostMeter {
 public:
  explicit CostMeter(JobCost& cost) : cost_(cost) {}
  ~CostMeter() {
    cost_.cpu_s += clock_seconds(CLOCK_THREAD_CPUTIME_ID) - cpu_;
    cost_.waited_for_core_s += waited_for_core() - waited_;
  }
  CostMeter(const CostMeter&) = delete;
  CostMeter& operator=(const CostMeter&) = delete;

 private:
  JobCost& cost_;
  double cpu_ = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
  double waited_ = waited_for_core();
};

/// Adds the code of the nodes in Python.
void add_codes(const Plan& plan, std::vector<std::string>& codes) {
  for (const NodeSpec& node : plan.nodes) {
    if (!node.info->code.empty()) codes.push_back(node.info->code);
  }
}

void add_inputs(const Plan& plan, std::set<std::filesystem::path>& inputs) {
  for (const InputOfPlan& input : input_files(plan)) inputs.insert(input.file);
}

std::vector<double> each(const std::vector<RunResult>& runs, double RunResult::*value) {
  std::vector<double> values;
  for (const RunResult& run : runs) values.push_back(run.*value);
  return values;
}

std::string utc_now() {
  return fmt::format("{:%F %T}", fmt::gmtime(std::time(nullptr)));
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

/// What tells the case of a job from others.
std::string case_of(const Job& job) {
  Job bare;
  bare.graph = job.graph;
  bare.overrides = job.overrides;
  bare.reference = job.reference;
  return to_message(bare);
}

/// The recording that judges the run of that seed.
std::filesystem::path recording_of(const Job& job, const Plan& plan, std::uint64_t seed) {
  return tactor::recording_of(job.reference_recording, graph_name(plan.graph.file), seed);
}

std::string content_of(const Plan& plan, const std::optional<Plan>& reference) {
  const std::string own = reference_key(plan, {});
  if (!reference) return content_key({to_yaml(plan.graph), own});
  return content_key({to_yaml(plan.graph), own, to_yaml(reference->graph), reference_key(*reference, {})});
}

}  // namespace

std::string StudyWorker::do_job(const std::string& message, const PoolLink& pool) {
  const Job job = from_message<Job>(message);
  // Asked for any type, the registry loads the library of its prefix.
  for (const std::string& library : job.libraries) static_cast<void>(registry_.find(library + "."));
  JobCost cost;
  switch (job.kind) {
    case JobKind::plan:
      return to_message(check(job));
    case JobKind::warm_up:
      return to_message(warm_up(job, pool));
    case JobKind::reference:
      make_reference(job, pool, cost);
      return to_message(cost);
    case JobKind::run:
      return to_message(run(job, pool));
  }
  TACTOR_DEMAND(false);
}

/// The seed decides nothing but `graph.seed`, so that one plan serves all seeds.
Plan StudyWorker::plan_of(const Job& job, const Overrides& overrides) const {
  Overrides seeded = overrides;
  seeded.push_back(option_patch("--seed", "seed", std::to_string(job.seed)));
  return make_plan(load_graph(job.graph, registry_, seeded));
}

/// For the seed of the job.
StudyWorker::Plans StudyWorker::plans_of(const Job& job) {
  std::string key = case_of(job);
  auto found = planned_.find(key);
  if (found == planned_.end()) {
    Plans plans{plan_of(job, job.overrides), {}};
    if (job.reference) plans.reference = plan_of(job, *job.reference);
    found = planned_.emplace(std::move(key), std::move(plans)).first;
  }
  Plans plans = found->second;
  plans.own.graph.seed = job.seed;
  if (plans.reference) plans.reference->graph.seed = job.seed;
  return plans;
}

CaseCheck StudyWorker::check(const Job& job) {
  CaseCheck found;
  try {
    const Plan plan = plan_of(job, job.overrides);
    if (plan.graph.clock == Clock::real) {
      throw InputError(job.graph.string() +
                       ": expected clock: virtual, under which all pipelines meet the same conditions, found clock: "
                       "real; add --set clock=virtual");
    }
    add_codes(plan, found.codes);
    add_inputs(plan, found.inputs);
    found.notes = checks_.check(plan);
    std::optional<Plan> reference;
    if (job.reference) {
      reference = plan_of(job, *job.reference);
      add_codes(*reference, found.codes);
      add_inputs(*reference, found.inputs);
      checks_.check(*reference);
    }
    found.title = plan.graph.title;
    found.content = content_of(plan, reference);
    found.duration_s = plan.graph.duration.seconds();
    found.has_to_warm_up = has_to_warm_up(plan);
    if (!job.reference_recording.empty()) {
      // What would be refused in a run is refused before the first one.
      for (const std::uint64_t seed : job.seeds) {
        const std::filesystem::path recording = recording_of(job, plan, seed);
        static_cast<void>(recorded_reference(recording, plan));
        found.inputs.insert(std::filesystem::absolute(recording));
      }
    } else if (!job.without_reference) {
      found.reference = reference_id(reference ? *reference : plan);
    }
    found.metrics = run_metrics(plan, !job.without_reference);
    found.metrics.add(run_times(plan));
    planned_.emplace(case_of(job), Plans{plan, std::move(reference)});
  } catch (const InputError& error) {
    found.result = CheckResult::refused;
    found.message = error.what();
    found.content = content_key({"refused", found.message});
  } catch (const std::exception& error) {
    found.result = CheckResult::failed;
    found.message = error.what();
  }
  found.libraries = registry_.loaded_libraries();
  found.code_files = code_files();
  found.loaded = loaded_code();
  return found;
}

WarmUp StudyWorker::warm_up(const Job& job, const PoolLink& pool) {
  WarmUp answer;
  const CostMeter meter(answer.cost);
  try {
    const Plans plans = plans_of(job);
    pool.begin_clock();
    answer.warmth = cached_warmth(plans.own, {job.cache_folder, [&](double) { return pool.go_on(); },
                                              [&](const std::string& note) { pool.note(note); }});
  } catch (const std::exception& error) {
    answer.cost.interrupted = !pool.go_on();
    answer.failure = error.what();
  }
  return answer;
}

void StudyWorker::make_reference(const Job& job, const PoolLink& pool, JobCost& cost) {
  const CostMeter meter(cost);
  try {
    const Plans plans = plans_of(job);
    pool.begin_clock();
    static_cast<void>(prepare_reference(
        plans.own, plans.reference ? &*plans.reference : nullptr,
        {job.cache_folder, [&](double) { return pool.go_on(); }, [&](const std::string& note) { pool.note(note); }}));
  } catch (const std::exception&) {
    cost.interrupted = !pool.go_on();
    // Else the run that needs it meets the same and keeps the message.
  }
  cost.depends_on_processor = processor_dependence();
}

RunAnswer StudyWorker::run(const Job& job, const PoolLink& pool) {
  const double control = measure_control();
  RunAnswer answer;
  {
    const CostMeter meter(answer.cost);
    answer.record = run_repeats(job, pool);
  }
  if (answer.record) {
    answer.record->control_us = control;
    answer.record->ran_on = this_machine();
    answer.record->finished = utc_now();
  }
  answer.cost.depends_on_processor = processor_dependence();
  return answer;
}

/// Nothing where it was interrupted.
std::optional<RunRecord> StudyWorker::run_repeats(const Job& job, const PoolLink& pool) {
  RunRecord record;
  std::string title;
  try {
    const Plans plans = plans_of(job);
    title = plans.own.graph.title;
    RunOptions options;
    options.cache_folder = job.cache_folder;
    options.note = [&](const std::string& note) { pool.note(note); };
    options.progress = [&](double, const char*) { return pool.go_on(); };
    if (plans.reference) options.reference = &*plans.reference;
    options.without_reference = job.without_reference;
    if (!job.reference_recording.empty()) options.reference_recording = recording_of(job, plans.own, job.seed);
    options.judge_from = job.judge_from;
    options.judge_whole = job.judge_whole;
    std::vector<RunResult> results;
    for (std::int64_t r = -job.warm_up; r < job.repeats; ++r) {
      pool.begin_clock();
      const double began = clock_seconds(CLOCK_MONOTONIC);
      RunResult result = execute(plans.own, options);
      if (result.interrupted || result.reference_interrupted) return std::nullopt;
      const double limit = job.time_limit_s.value_or(std::numeric_limits<double>::infinity());
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
    if (!job.all_curves) {
      std::erase_if(record.result.series, [](const Series& curve) { return curve.name != "one_step_error"; });
    }
  } catch (const InputError& error) {
    record.status = RunStatus::refused;
    record.message = error.what();
  } catch (const std::exception& error) {
    if (!pool.go_on()) return std::nullopt;
    record.status = RunStatus::failed;
    record.message = error.what();
  }
  record.result.title = title;
  return record;
}

}  // namespace tactor
