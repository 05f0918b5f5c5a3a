// The live engine: a run of a Plan in real time, one CAF actor a node, devices in loops of their own.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "framework/engine/live/live_engine.hpp"

namespace tactor {

/// The live engine. The plan must outlive it.
///
/// The rules of the Dispatcher decide which node steps when and what it sees; the time is CLOCK_MONOTONIC since the
/// start. A step is made by the node's actor, in its lane, and passes when it is done: what it cost is what it took,
/// the way to the actor's thread included. So a run whose costs are recorded and given to the virtual clock as traces
/// takes the same steps with the same values.
///
/// Edges keep their queues in the dispatcher; a message between actors is only the request to step, and there is at
/// most one a node, so that no mailbox holds a backlog.
class LiveRun final : public LiveEngine {
 public:
  /// Throws as LiveLibrary::make.
  explicit LiveRun(const Plan& plan);
  ~LiveRun() override;
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  void stop_when(std::function<bool()> asked) override;
  void run(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on) override;
  [[nodiscard]] const std::optional<std::string>& failure() const override;
  [[nodiscard]] bool is_abandoned() const override;
  [[nodiscard]] PlanNodes& nodes() override;
  [[nodiscard]] const LiveStatus& status() const override;
  [[nodiscard]] const NodeStatistics& node_statistics(std::size_t node) const override;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

}  // namespace tactor
