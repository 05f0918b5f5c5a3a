// The deterministic engine: a discrete-event run of a Plan under a virtual clock.
//
// A step is made at once and passes when the cost that the graph's model gives it has passed (see Dispatcher for what
// nodes see). The same plan gives the same sequence of steps and the same values.
#pragma once

#include <atomic>
#include <vector>

#include "framework/engine/cost.hpp"
#include "framework/engine/engine.hpp"

namespace tactor {

class VirtualEngine : public Engine {
 public:
  explicit VirtualEngine(const Plan& plan, const EngineOptions& options = {});

  /// The dispatcher, before the start and between two advances.
  [[nodiscard]] Dispatcher& dispatcher() { return dispatcher_; }
  /// Makes the steps that begin before `t`, which is not before `now`, and moves the time there. What happens at `t`
  /// itself is left to the next advance. Throws RunError with the node's name if a step throws; the metrics are then of
  /// the run up to there.
  virtual void advance_to(Time t);
  /// Starts, and runs to the end.
  void run() {
    start();
    advance_to(end());
  }

  void with_dispatcher(const std::function<void(Dispatcher&)>& work) override { work(dispatcher_); }
  [[nodiscard]] bool steps_on_caller() const override { return true; }
  bool feed(std::size_t node, std::optional<Time> valid, std::span<const FedValue> values) override;
  void set(std::size_t node, std::shared_ptr<const void> params, const SetEvent& event) override;
  [[nodiscard]] bool is_set(std::size_t /*node*/) override { return true; }
  void stop_when(std::function<bool()> asked) override { stop_asked_ = std::move(asked); }
  void start() override { dispatcher_.start(); }
  void advance(Duration duration, const Attendance& attendance) override;
  [[nodiscard]] bool is_running() override { return !stopped_ && now() < end(); }
  [[nodiscard]] Time now() override { return dispatcher_.now(); }
  void stop(const std::string& why) override;
  void finish(const Attendance& attendance) override;
  [[nodiscard]] std::optional<std::string> failure() const override { return failure_; }
  [[nodiscard]] PlanNodes& nodes() override { return nodes_; }
  [[nodiscard]] EngineStatus status() override { return dispatcher_.status(); }
  [[nodiscard]] NodeStatistics node_statistics(std::size_t node) const override;
  [[nodiscard]] std::vector<Duration> step_times(std::size_t node) const override { return step_times_[node]; }
  [[nodiscard]] EdgeStatistics edge_statistics(std::size_t edge) const override {
    return dispatcher_.edge_statistics(edge);
  }
  [[nodiscard]] Duration cpu_time() const override;

 protected:
  /// For a run that is made again: `costs` of the nodes stand for those of the plan, and `lanes` steps the nodes of
  /// `chains`.
  VirtualEngine(const Plan& plan, const EngineOptions& options, const std::vector<CostModel>& costs, Chains chains,
                ExternalInputs* lanes);

  [[nodiscard]] virtual Time end() const { return Time{} + plan_.graph.duration; }

  const Plan& plan_;

 private:
  void step(const Dispatcher::StepRequest& request);
  /// Advances to `t`, and lets requests of nodes be done as time passes.
  void advance_and_serve(Time t, const Attendance& attendance);

  const EngineOptions options_;
  const bool serves_;  // nodes ask something of the run
  PlanNodes nodes_;
  std::vector<CostDraw> costs_;
  Dispatcher dispatcher_;
  std::vector<NodeStatistics> node_statistics_;    // without what the dispatcher counts
  std::vector<std::vector<Duration>> step_times_;  // by node; empty if they are not kept
  std::function<bool()> stop_asked_ = [] { return false; };
  std::optional<std::string> failure_;
  std::atomic<bool> stopped_ = false;  // by any thread
};

}  // namespace tactor
