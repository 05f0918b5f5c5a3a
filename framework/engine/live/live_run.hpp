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

  void add_tap(std::size_t node, std::size_t output, Tap& tap) override;
  void add_step_tap(Tap& tap) override;
  void add_tick_tap(Tap& tap) override;
  void add_stop_tap(Tap& tap) override;
  void remove_tap(const Tap& tap) override;
  bool feed(std::size_t node, std::optional<Time> valid, const void* value) override;
  Time tune(std::size_t node, std::shared_ptr<const void> params) override;
  [[nodiscard]] bool is_tuned(std::size_t node) override;
  void stop_when(std::function<bool()> asked) override;
  void start() override;
  [[nodiscard]] bool is_running() override;
  void stop(const std::string& why) override;
  [[nodiscard]] LiveStatus look() override;
  void finish(const std::function<void()>& while_waiting) override;
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
