// The deterministic engine: a discrete-event run of a Plan under a virtual clock.
//
// Semantics: a node that steps at time t sees the messages that arrived by t. What it sends becomes visible at t + its
// cost; until then the node is busy and its triggers wait by the policies of their queues. A node with a rate that is
// still busy when its tick comes misses that tick. At one instant messages arrive first, then nodes step in the
// order of the plan; a node whose cost has just passed steps anew after the others, so that it sees what they made of
// its results. The same plan gives the same sequence of steps and the same values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "framework/graph/plan.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// Watches a run. The default watches nothing.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  /// A message of a recorded output became visible.
  virtual void on_message(std::size_t stream, const Stamp& stamp, const void* payload) {
    static_cast<void>(stream), static_cast<void>(stamp), static_cast<void>(payload);
  }
  /// A message arrived at a sink's `reference` input.
  virtual void on_reference(std::size_t edge, const Stamp& stamp, const void* payload) {
    static_cast<void>(edge), static_cast<void>(stamp), static_cast<void>(payload);
  }
  /// A node stepped at `now`; `cost` is the model's.
  virtual void on_step(std::size_t node, Time now, Duration cost) {
    static_cast<void>(node), static_cast<void>(now), static_cast<void>(cost);
  }
  /// Called about every 10 ms of virtual time; false ends the run there.
  virtual bool on_progress(Time now) {
    static_cast<void>(now);
    return true;
  }
};

/// What a node did in a run.
struct NodeFigures {
  std::uint64_t steps = 0;
  std::uint64_t missed_ticks = 0;
  std::vector<std::uint32_t> cpu_ns;  ///< CPU time of each step, where it was measured
};

/// What an edge carried in a run.
struct EdgeFigures {
  std::uint64_t delivered = 0;
  std::uint64_t dropped = 0;
  std::uint64_t superseded = 0;  ///< replaced on a `latest` edge before its reader looked
};

/// A run of a plan. The plan must outlive it.
class VirtualClock {
 public:
  /// Makes the nodes and connects them. Throws InputError with the node's name where a node refuses its input.
  /// `measure_cpu`: time every step by the thread's CPU clock.
  VirtualClock(const Plan& plan, bool measure_cpu);
  ~VirtualClock();
  VirtualClock(const VirtualClock&) = delete;
  VirtualClock& operator=(const VirtualClock&) = delete;

  /// In a reference run: every node meets its counterpart in the run being judged.
  void follow(const VirtualClock& judged);

  /// Runs from time zero to the graph's duration. Throws RunError with the node's name where a step throws. Once only.
  void run(RunObserver& observer);

  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] Node& node(std::size_t index) { return *nodes_[index]; }
  [[nodiscard]] const Node& node(std::size_t index) const { return *nodes_[index]; }
  [[nodiscard]] const NodeFigures& node_figures(std::size_t index) const;
  [[nodiscard]] EdgeFigures edge_figures(std::size_t index) const;
  /// The time at which the run ended.
  [[nodiscard]] Time now() const { return now_; }

 private:
  struct NodeState;
  struct EdgeState;
  struct Event;
  struct Later;

  void schedule_tick(std::size_t node);
  void handle(const Event& event);
  void step(std::size_t node, bool first);
  void release(std::size_t node);
  void deliver(std::size_t edge, const Stamp& stamp, const std::byte* payload);
  void arrive(std::size_t edge, const Stamp& stamp, const std::byte* payload);
  void flush_blocked(std::size_t reader);

  const Plan& plan_;
  const bool measure_cpu_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<NodeState> states_;
  std::vector<EdgeState> edges_;
  std::vector<Event> events_;  // a heap, the earliest on top
  std::uint64_t event_count_ = 0;
  Time now_;
  RunObserver* observer_ = nullptr;
};

}  // namespace tactor
