// The deterministic engine: a discrete-event run of a Plan under a virtual clock.
//
// A step is made at once and passes when the cost that the graph's model gives it has passed (see Dispatcher for what
// nodes see). The same plan gives the same sequence of steps and the same values.
#pragma once

#include <vector>

#include "framework/engine/cost.hpp"
#include "framework/engine/dispatcher.hpp"
#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// A run of a plan. The plan must outlive it.
class VirtualClock {
 public:
  /// Makes the nodes. Throws InputError with the node's name where a node refuses its input.
  /// `measure_cpu`: time every step by the thread's CPU clock.
  VirtualClock(const Plan& plan, bool measure_cpu);

  /// Runs from time zero to the graph's duration. Throws RunError with the node's name where a step throws, and what
  /// the observer throws; the metrics are then of the run up to there. Once only.
  void run(RunObserver& observer);

  [[nodiscard]] PlanNodes& nodes() { return nodes_; }
  [[nodiscard]] const PlanNodes& nodes() const { return nodes_; }
  [[nodiscard]] const NodeStatistics& node_statistics(std::size_t index) const { return node_statistics_[index]; }
  [[nodiscard]] const EdgeStatistics& edge_statistics(std::size_t index) const { return edge_statistics_[index]; }
  /// The time at which the run ended.
  [[nodiscard]] Time now() const { return now_; }

 private:
  void step(Dispatcher& dispatcher, const Dispatcher::StepRequest& request, RunObserver& observer);
  void run_to_end(Dispatcher& dispatcher, RunObserver& observer);
  void keep_statistics(const Dispatcher& dispatcher);

  const Plan& plan_;
  const bool measure_cpu_;
  PlanNodes nodes_;
  std::vector<CostDraw> costs_;
  std::vector<NodeStatistics> node_statistics_;
  std::vector<EdgeStatistics> edge_statistics_;
  Time now_;
};

/// The CPU time of the calling thread in ns.
std::int64_t thread_cpu_ns();

}  // namespace tactor
