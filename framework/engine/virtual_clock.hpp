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
  /// `external` and `inputs`: see Dispatcher; `meter`: see PlanNodes.
  VirtualClock(const Plan& plan, bool measure_cpu, std::vector<bool> external = {}, ExternalInputs* inputs = nullptr,
               NodeMeter* meter = nullptr);

  /// From now on keeps what each step took. Needs `measure_cpu`; before the first step.
  void keep_step_times() { step_times_.resize(plan_.nodes.size()); }
  /// The CPU time of each step of a node, in order; empty where they are not kept.
  [[nodiscard]] std::vector<Duration> step_times(std::size_t node) const {
    return step_times_.empty() ? std::vector<Duration>{} : step_times_[node];
  }
  /// Where taps are added; they may be before the start and between two advances.
  [[nodiscard]] Dispatcher& dispatcher() { return dispatcher_; }
  /// Starts the nodes at time zero. Once, before the first advance.
  void start();
  /// Makes the steps that begin before `t`, which is not before `now`, and moves the time there. What happens at `t`
  /// itself is left to the next advance. Throws RunError with the node's name where a step throws; the metrics are then
  /// of the run up to there.
  void advance_to(Time t);
  /// Both, to the graph's duration.
  void run() {
    start();
    advance_to(Time{} + plan_.graph.duration);
  }

  [[nodiscard]] PlanNodes& nodes() { return nodes_; }
  [[nodiscard]] const PlanNodes& nodes() const { return nodes_; }
  [[nodiscard]] NodeStatistics node_statistics(std::size_t index) const;
  [[nodiscard]] EdgeStatistics edge_statistics(std::size_t index) const { return dispatcher_.edge_statistics(index); }
  /// The time up to which it has run.
  [[nodiscard]] Time now() const { return dispatcher_.now(); }

 private:
  void step(const Dispatcher::StepRequest& request);

  const Plan& plan_;
  const bool measure_cpu_;
  PlanNodes nodes_;
  std::vector<CostDraw> costs_;
  Dispatcher dispatcher_;
  std::vector<NodeStatistics> node_statistics_;    // without what the dispatcher counts
  std::vector<std::vector<Duration>> step_times_;  // by node, where they are kept; else empty
};

/// The CPU time of the calling thread in ns.
std::int64_t thread_cpu_ns();

}  // namespace tactor
