// Runs variants of a graph on the hand path of the original: what they cost, and how far their forces are from its
// reference run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/lean/lean_search.hpp"
#include "app/run/timing.hpp"
#include "framework/engine/reference.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

/// Which force is held against the reference run.
enum class LeanMetric {
  delivered,  ///< what the device is told to display, at every tick
  physics,    ///< each physics force, at the time it stands for, so that no delay is in it
};

/// The metric as options name it.
const char* word(LeanMetric metric);

struct LeanMeasureOptions {
  LeanMetric metric = LeanMetric::delivered;
  std::optional<double> duration_s;  ///< of each run; absent: the graph's
  Repeats repeats = warmed_up(3);    ///< runs of each seed
  std::filesystem::path cache_folder;
  std::function<void(const std::string& note)> note;
  /// Asked every 10 ms of simulated time; true ends the work with Interrupted.
  std::function<bool()> interrupted = [] { return false; };
};

/// Measures variants of one graph. The error is the RMS over all seeds of the difference between the variant's force
/// and the force of the reference run (physics at 10 kHz, no costs, no encoder steps) of the ORIGINAL graph, for the
/// same seed; torque likewise, and a variant that computes no torque errs by all of the reference's. The cost is the
/// CPU time of the steps of all nodes but the sinks for a simulated second, the mean over the seeds and the median of
/// the repeats. The first run of each seed tells the error; it is the warm-up, and counts for the cost only where
/// nothing is repeated. A fixed computation is timed before each run.
class LeanMeasure {
 public:
  /// Throws InputError where the graph cannot be measured so: its clock is real, its loop is closed (the hand's path
  /// would depend on the forces), or no sink tells the errors.
  LeanMeasure(GraphSpec original, LeanMeasureOptions options);

  /// Every seed is run once: the errors, and what that run cost.
  [[nodiscard]] LeanMetrics first_look(const GraphSpec& graph, std::span<const std::uint64_t> seeds);
  /// A graph with the metrics of its first look.
  struct Looked {
    const GraphSpec* graph;
    LeanMetrics* metrics;
  };
  /// Repeats for the cost: a run of the first graph, one of the second, and so on, and all over again, so that a
  /// machine that slows down does so for all of them. Where they are not to be repeated the first look stays.
  void time_by_turns(std::span<const Looked> graphs, std::span<const std::uint64_t> seeds);

  /// A first look at a graph, and where it keeps the limits, at the one before it; then both by turns. With
  /// `must_save` that ends with the first turn that saves nothing, or before it where the first look costs far more.
  [[nodiscard]] LeanPair compare(const GraphSpec& before, const GraphSpec& after, bool must_save,
                                 std::span<const std::uint64_t> seeds, const LeanLimits& limits);

  /// Of all runs since this was last asked.
  [[nodiscard]] TimingNote timing();

 private:
  struct Run {
    double cost = 0;  // us of CPU time a simulated second
    double error = 0, max_error = 0;
    std::optional<double> torque_error;
    std::optional<double> reference_torque;
    Time warm_since;
  };
  struct Truth {
    Plan plan;  // that made it
    Reference reference;
    std::optional<double> torque;     // N m, RMS; none where the original has none
    std::optional<Time> judged_from;  // when the original's nodes are warm; nothing before it has run
  };
  const Truth& truth(std::uint64_t seed);
  void take_turn(std::span<const Looked> graphs, std::span<const std::uint64_t> seeds);
  void keep_medians(std::span<const Looked> graphs);
  [[nodiscard]] GraphSpec prepared(const GraphSpec& graph, std::uint64_t seed) const;
  [[nodiscard]] Run run(const GraphSpec& graph, std::uint64_t seed, const Truth& truth);

  GraphSpec original_;
  LeanMeasureOptions options_;
  std::map<std::uint64_t, Truth> truths_;
  std::vector<double> control_us_, spreads_;  // since timing() was last asked
};

}  // namespace tactor
