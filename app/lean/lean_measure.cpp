#include "app/lean/lean_measure.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "app/run/references.hpp"
#include "app/run/run.hpp"
#include "app/run/step_times.hpp"
#include "framework/engine/virtual_clock.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

namespace {

/// Lets a run end where the user wants it.
class Watch final : public RunObserver {
 public:
  explicit Watch(const std::function<bool()>& interrupted) : interrupted_(interrupted) {}
  bool on_progress(Time) override { return !interrupted_(); }

 private:
  const std::function<bool()>& interrupted_;
};

std::optional<double> figure(const Report& report, const std::string& name) {
  for (const auto& [key, value] : report.figures()) {
    if (key == name) return value;
  }
  return std::nullopt;
}

/// Keeps the least time of each step.
void keep_least(StepTimes& times, const StepTimes& others) {
  for (std::size_t n = 0; n < times.size(); ++n) {
    for (std::size_t i = 0; i < std::min(times[n].size(), others[n].size()); ++i) {
      times[n][i] = std::min(times[n][i], others[n][i]);
    }
  }
}

/// us a simulated second.
double cost_of(const StepTimes& times, double seconds) {
  double ns = 0;
  for (const auto& node : times) {
    for (const std::uint32_t step : node) ns += step;
  }
  return 1e-3 * ns / seconds;
}

const char* word(LeanMetric metric) {
  return metric == LeanMetric::delivered ? "delivered" : "physics";
}

}  // namespace

LeanMeasure::LeanMeasure(GraphSpec original, LeanMeasureOptions options)
    : original_(std::move(original)), options_(std::move(options)) {
  if (original_.clock == Clock::real) {
    throw InputError(original_.file.string() +
                     ": expected clock: virtual, which repeats a run, found clock: real; add --set clock=virtual");
  }
  if (must_be_followed(PlanNodes(make_plan(prepared(original_, original_.seed))))) {
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
    truth.reference =
        cached_reference(make_plan(prepared(original_, seed)), {options_.cache_folder, go_on, options_.note});
  } catch (const RunError&) {
    if (options_.interrupted()) throw LeanInterrupted();
    throw;
  }
  truth.torque = run(original_, seed, truth.reference).reference_torque;
  return truths_.emplace(seed, std::move(truth)).first->second;
}

LeanMeasure::Run LeanMeasure::run(const GraphSpec& graph, std::uint64_t seed, const Reference& reference) const {
  const Plan plan = make_plan(prepared(graph, seed));
  VirtualClock engine(plan, true);
  Watch watch(options_.interrupted);
  engine.run(watch);
  if (options_.interrupted()) throw LeanInterrupted();
  set_reference(engine.nodes(), reference);
  Report report;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    report.begin(plan.nodes[n].name);
    if (plan.nodes[n].info->sink) engine.nodes()[n].report(report);
  }
  const std::string metric = word(options_.metric);
  const auto error = figure(report, metric + ".force.rms_error_N");
  const auto most = figure(report, metric + ".force.max_error_N");
  if (!error || !most) {
    throw InputError(
        graph.file.string() + ": nothing tells the error of the " + metric +
        " force; expected a sink.metrics with edges into `commanded` and `force`, and a run that is longer "
        "than its `settle`");
  }
  Run result{.times = step_times(engine, plan.nodes.size()), .error = *error, .max_error = *most};
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    if (plan.nodes[n].info->sink) result.times[n].clear();
  }
  result.torque_error = figure(report, metric + ".torque.rms_error_Nm");
  result.reference_torque = figure(report, "reference.torque.rms_Nm");
  return result;
}

LeanFigures LeanMeasure::operator()(const GraphSpec& graph, std::span<const std::uint64_t> seeds,
                                    const LeanLimits* limits, std::optional<double> worth) {
  LeanFigures figures;
  // Outside of what may be refused: the original must be measurable.
  for (const std::uint64_t seed : seeds) truth(seed);
  const double seconds = prepared(graph, graph.seed).duration.seconds();
  const auto count = static_cast<double>(seeds.size());
  std::vector<StepTimes> times;
  const auto cost = [&] {
    double sum = 0;
    for (const StepTimes& t : times) sum += cost_of(t, seconds);
    return sum / count;
  };
  try {
    double squares = 0, torque_squares = 0;
    for (const std::uint64_t seed : seeds) {
      Run found = run(graph, seed, truth(seed).reference);
      times.push_back(std::move(found.times));
      squares += found.error * found.error;
      figures.max_error = std::max(figures.max_error, found.max_error);
      const std::optional<double>& whole = truth(seed).torque;
      const double torque = whole ? found.torque_error.value_or(*whole) : 0;
      torque_squares += torque * torque;
    }
    figures.error = std::sqrt(squares / count);
    figures.torque_error = std::sqrt(torque_squares / count);
    figures.cost = cost();
    if ((limits != nullptr && !limits->keep(figures)) || (worth && figures.cost > *worth)) return figures;
    for (int repeat = 1; repeat < options_.repeats; ++repeat) {
      for (std::size_t i = 0; i < seeds.size(); ++i) {
        keep_least(times[i], run(graph, seeds[i], truth(seeds[i]).reference).times);
      }
    }
    figures.cost = cost();
  } catch (const InputError& error) {
    figures.refused = error.what();
  } catch (const RunError& error) {
    figures.refused = error.what();
  }
  return figures;
}

}  // namespace tactor
