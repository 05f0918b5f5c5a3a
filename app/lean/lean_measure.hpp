// Runs variants of a graph on the hand path of the original: what they cost, and how far their forces are from its
// reference run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/lean/lean_search.hpp"
#include "app/run/step_times.hpp"
#include "framework/engine/reference.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

/// Which force is held against the reference run.
enum class LeanMetric {
  delivered,  ///< what the device is told to display, at every tick
  physics,    ///< each physics force, at the time it stands for, so that no delay is in it
};

struct LeanMeasureOptions {
  LeanMetric metric = LeanMetric::delivered;
  std::optional<double> duration_s;  ///< of each run; absent: the graph's
  int repeats = 3;                   ///< runs of each seed whose cost counts
  std::filesystem::path cache_folder;
  std::function<void(const std::string& note)> note;
  /// Asked every 10 ms of simulated time; true ends the work with LeanInterrupted.
  std::function<bool()> interrupted = [] { return false; };
};

/// The work was interrupted by the user.
class LeanInterrupted : public std::runtime_error {
 public:
  LeanInterrupted() : std::runtime_error("interrupted") {}
};

/// Measures variants of one graph. The error is the RMS over all seeds of the difference between the variant's force
/// and the force of the reference run (physics at 10 kHz, no costs, no encoder steps) of the ORIGINAL graph, for the
/// same seed; torque likewise, and a variant that computes no torque errs by all of the reference's. The cost is the
/// CPU time of the steps of all nodes but the sinks for a simulated second, the mean over the seeds. Runs of one seed
/// take the same steps with the same work, so each step counts with the least of its times: what is more was the
/// machine's.
class LeanMeasure {
 public:
  /// Throws InputError where the graph cannot be measured so: its clock is real, its loop is closed (the hand's path
  /// would depend on the forces), or no sink tells the errors.
  LeanMeasure(GraphSpec original, LeanMeasureOptions options);

  /// Every seed is run once, and `repeats` times for the cost, where the limits are kept (or none are given) and the
  /// first runs cost no more than `worth` (or none is given).
  [[nodiscard]] LeanFigures operator()(const GraphSpec& graph, std::span<const std::uint64_t> seeds,
                                       const LeanLimits* limits, std::optional<double> worth = {});

 private:
  struct Run {
    StepTimes times;
    double error = 0, max_error = 0;
    std::optional<double> torque_error;
    std::optional<double> reference_torque;
  };
  struct Truth {
    Reference reference;
    std::optional<double> torque;  // N m, RMS; none where the original has none
  };
  const Truth& truth(std::uint64_t seed);
  [[nodiscard]] GraphSpec prepared(const GraphSpec& graph, std::uint64_t seed) const;
  [[nodiscard]] Run run(const GraphSpec& graph, std::uint64_t seed, const Reference& reference) const;

  GraphSpec original_;
  LeanMeasureOptions options_;
  std::map<std::uint64_t, Truth> truths_;
};

}  // namespace tactor
