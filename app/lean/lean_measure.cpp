#include "app/lean/lean_measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "app/run/references.hpp"
#include "app/run/run_metrics.hpp"
#include "app/run/timed_run.hpp"
#include "app/statistics.hpp"
#include "framework/engine/warmth.hpp"
#include "framework/graph/plan_metrics.hpp"
#include "framework/session/session.hpp"

namespace tactor {

namespace {

std::optional<double> value_of(const Report& report, const std::string& name) {
  for (const auto& [key, value] : report.metrics()) {
    if (key == name) return value;
  }
  return std::nullopt;
}

/// The name of one of the metrics that are looked at: `delivered.force.rms_error_N`.
std::string error_name(LeanMetric metric, const char* error) {
  return fmt::format("{}.{}", word(metric), error);
}

/// Since when the nodes of a run that has ended are warm. Throws InputError where they are not by the time from which
/// on the original is judged, or not at all.
Time warm_since_of(const PlanNodes& nodes, const std::optional<Time>& judged_from) {
  const Warmth warmth = warmth_of(nodes);
  const Time latest = judged_from.value_or(Time{nodes.plan().graph.duration.ns});
  if (warmth.since && *warmth.since <= latest) return *warmth.since;
  throw InputError(fmt::format(
      "{}: node {} is not warm after {} s: {}; errors are compared only when all nodes are warm: make the run longer",
      nodes.plan().graph.file.string(), warmth.last, latest.seconds(), warmth.when));
}

std::string without_error(const GraphSpec& graph, LeanMetric metric) {
  return fmt::format(
      "{}: no node reports the error of the {} force; expected a sink.metrics with edges into `commanded` and `force`, "
      "and a run that is longer than its `settle`",
      graph.file.string(), word(metric));
}

}  // namespace

const char* word(LeanMetric metric) {
  return metric == LeanMetric::delivered ? "delivered" : "physics";
}

LeanMeasure::LeanMeasure(GraphSpec original, LeanMeasureOptions options)
    : original_(std::move(original)), options_(std::move(options)) {
  if (original_.clock == Clock::real) {
    throw InputError(original_.file.string() +
                     ": expected clock: virtual, which repeats a run, found clock: real; add --set clock=virtual");
  }
  const Plan plan = make_plan(prepared(original_, original_.seed));
  const MetricMap reported = run_metrics(plan, true).reported;
  for (const char* error : {"force.rms_error_N", "force.max_error_N"}) {
    if (!reported.contains(error_name(options_.metric, error))) {
      throw InputError(without_error(original_, options_.metric));
    }
  }
  if (must_be_followed(PlanNodes(plan))) {
    throw InputError(original_.file.string() +
                     ": expected a hand whose path does not depend on the forces, found a device in closed loop; add "
                     "--set NODE.loop=open");
  }
}

GraphSpec LeanMeasure::prepared(const GraphSpec& graph, std::uint64_t seed) const {
  GraphSpec run = graph;
  run.seed = seed;
  run.record.clear();
  if (options_.duration_s) run.duration = Duration::from_seconds(*options_.duration_s);
  return run;
}

const LeanMeasure::Truth& LeanMeasure::truth(std::uint64_t seed) {
  const auto known = truths_.find(seed);
  if (known != truths_.end()) return known->second;
  const auto go_on = [this](double) { return !options_.interrupted(); };
  Truth truth;
  try {
    const Plan plan = make_plan(prepared(original_, seed));
    truth.plan = make_reference_plan(plan);
    truth.reference = cached_reference(plan, {options_.cache_folder, go_on, options_.note});
  } catch (const RunError&) {
    if (options_.interrupted()) throw Interrupted();
    throw;
  }
  const Run original = run(original_, seed, truth);
  truth.torque = original.reference_torque;
  truth.judged_from = original.warm_since;
  return truths_.emplace(seed, std::move(truth)).first->second;
}

LeanMeasure::Run LeanMeasure::run(const GraphSpec& graph, std::uint64_t seed, const Truth& truth) {
  const Plan plan = make_plan(prepared(graph, seed));
  control_us_.push_back(measure_control());
  Session session(plan, {.engine = {.measure_cpu = true}});
  run_to_end(session, options_.interrupted);
  const ReferenceRate rate = rate_of(truth.reference, &truth.plan, plan, session.now() - Time{},
                                     [&](std::size_t edge) { return session.edge_statistics(edge).delivered; });
  if (!rate.too_coarse.empty()) throw InputError(graph.file.string() + ": no error can be told: " + rate.too_coarse);
  set_reference(session.nodes(), truth.reference);
  const Time warm_since = warm_since_of(session.nodes(), truth.judged_from);
  Report report;
  report.judge_from(truth.judged_from.value_or(warm_since));
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    if (!plan.nodes[n].info->sink) continue;
    report.ask(session.nodes()[n], plan.nodes[n].name, node_metrics(plan, n, true).reported);
  }
  const auto error = value_of(report, error_name(options_.metric, "force.rms_error_N"));
  const auto most = value_of(report, error_name(options_.metric, "force.max_error_N"));
  if (!error || !most) throw InputError(without_error(graph, options_.metric));
  Run result{.error = *error, .max_error = *most, .warm_since = warm_since};
  const std::vector<double> costs = node_costs(session);
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    if (!plan.nodes[n].info->sink) result.cost += costs[n];
  }
  result.torque_error = value_of(report, error_name(options_.metric, "torque.rms_error_Nm"));
  result.reference_torque = value_of(report, "reference.torque.rms_Nm");
  return result;
}

LeanMetrics LeanMeasure::first_look(const GraphSpec& graph, std::span<const std::uint64_t> seeds) {
  LeanMetrics metrics;
  // Outside of what may be refused: the original must be measurable.
  for (const std::uint64_t seed : seeds) truth(seed);
  const auto count = static_cast<double>(seeds.size());
  try {
    double squares = 0, torque_squares = 0;
    for (const std::uint64_t seed : seeds) {
      const Run found = run(graph, seed, truth(seed));
      metrics.cost += found.cost / count;
      squares += found.error * found.error;
      metrics.max_error = std::max(metrics.max_error, found.max_error);
      const std::optional<double>& whole = truth(seed).torque;
      const double torque = whole ? found.torque_error.value_or(*whole) : 0;
      torque_squares += torque * torque;
    }
    metrics.error = std::sqrt(squares / count);
    metrics.torque_error = std::sqrt(torque_squares / count);
  } catch (const InputError& error) {
    metrics.refused = error.what();
  } catch (const RunError& error) {
    metrics.refused = error.what();
  }
  return metrics;
}

void LeanMeasure::take_turn(std::span<const Looked> graphs, std::span<const std::uint64_t> seeds) {
  for (const Looked& looked : graphs) looked.metrics->repeats.push_back(0);
  for (const std::uint64_t seed : seeds) {
    for (const Looked& looked : graphs) {
      looked.metrics->repeats.back() += run(*looked.graph, seed, truth(seed)).cost / static_cast<double>(seeds.size());
    }
  }
}

void LeanMeasure::keep_medians(std::span<const Looked> graphs) {
  for (const Looked& looked : graphs) {
    if (looked.metrics->repeats.empty()) continue;
    looked.metrics->cost = median(looked.metrics->repeats);
    spreads_.push_back(spread_of_repeats(looked.metrics->repeats));
  }
}

void LeanMeasure::time_by_turns(std::span<const Looked> graphs, std::span<const std::uint64_t> seeds) {
  if (options_.repeats.warm_up == 0) return;
  for (std::int64_t repeat = 0; repeat < options_.repeats.count; ++repeat) take_turn(graphs, seeds);
  keep_medians(graphs);
}

LeanPair LeanMeasure::compare(const GraphSpec& before, const GraphSpec& after, bool must_save,
                              std::span<const std::uint64_t> seeds, const LeanLimits& limits) {
  LeanPair pair;
  pair.after = first_look(after, seeds);
  if (!pair.after.refused.empty() || !limits.keep(pair.after)) return pair;
  pair.before = first_look(before, seeds);
  const std::array<Looked, 2> both{{{&before, &pair.before}, {&after, &pair.after}}};
  // A single look may err by that much.
  if (options_.repeats.warm_up == 0 || (must_save && pair.after.cost > 1.1 * pair.before.cost)) return pair;
  for (std::int64_t repeat = 0; repeat < options_.repeats.count; ++repeat) {
    take_turn(both, seeds);
    if (must_save && pair.savings().back() <= 0) break;
  }
  keep_medians(both);
  return pair;
}

TimingNote LeanMeasure::timing() {
  const TimingNote note = timing_note(control_us_, spreads_, options_.repeats, spread_warning(spreads_));
  control_us_.clear();
  spreads_.clear();
  return note;
}

}  // namespace tactor
