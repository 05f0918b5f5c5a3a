// The live engine: a run of a Plan in real time, one CAF actor a node, devices in loops of their own.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "framework/engine/live/live_status.hpp"
#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// A run of a plan whose clock is real. The plan must outlive it.
///
/// The rules of the Dispatcher decide which node steps when and what it sees; the time is CLOCK_MONOTONIC since the
/// start. A step is made by the node's actor, in its lane, and passes when it is done: what it cost is what it took,
/// the way to the actor's thread included. So a run whose costs are recorded and given to the virtual clock as traces
/// takes the same steps with the same values.
///
/// Edges keep their queues in the dispatcher; a message between actors is only the request to step, and there is at
/// most one a node, so that no mailbox holds a backlog.
class LiveRun {
 public:
  /// Makes the nodes. Throws InputError with the node's name where a node refuses its input, and where a node asks for
  /// a core that this machine does not have.
  explicit LiveRun(const Plan& plan);
  /// Must not be called where the run `is_abandoned`.
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /// Runs until the graph's duration has passed, `go_on` says no (asked about ten times a second, on the calling
  /// thread), or something fails; then lets the devices ramp down and ends everything. The observer is called on the
  /// calling thread and may be slow. Throws RunError before anything moves where a privilege is missing and the graph
  /// says `on_missing_privilege: fail`. Once only.
  void run(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on);

  /// Why the run ended before its time, with the node's name; none where it did not fail.
  [[nodiscard]] const std::optional<std::string>& failure() const;
  /// True where a step never came back: its thread still uses this object, so only the end of the process may follow.
  [[nodiscard]] bool is_abandoned() const;

  [[nodiscard]] PlanNodes& nodes();
  /// The state at the end.
  [[nodiscard]] const LiveStatus& status() const;
  /// CPU time of the steps of a node, in the pool of some of them; empty for one in the real-time lane, which has its
  /// loop's figures.
  [[nodiscard]] const NodeFigures& node_figures(std::size_t node) const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

}  // namespace tactor
