// The steps that actors make in a live run, from the request to the time at which they pass.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "framework/engine/cost.hpp"
#include "framework/engine/dispatcher.hpp"

namespace tactor {

/// Used under the engine's lock.
class ActorSteps {
 public:
  using Params = std::vector<std::shared_ptr<const void>>;
  /// What is known of the steps of one node.
  struct Node {
    Dispatcher::StepRequest request;  ///< the step that it is making
    Params tuned;                     ///< parameters that hold from its next step on
    Params to_tune;                   ///< those that hold from the step on that it is making
    std::optional<CostDraw> cost;     ///< where the graph imposes what it declares
    NodeStatistics statistics;        ///< CPU time; the counts only at the end of the run
    bool at_rest = false;             ///< of a device outside of the real-time lane
    bool failed = false;              ///< in any lane
  };

  explicit ActorSteps(const Plan& plan);

  [[nodiscard]] Node& operator[](std::size_t node) { return nodes_[node]; }
  [[nodiscard]] const Node& operator[](std::size_t node) const { return nodes_[node]; }

  /// Begins the steps that the dispatcher asks for.
  void begin_ready(Dispatcher& dispatcher);
  /// No step begins any more.
  void end() { ended_ = true; }
  /// Nodes whose steps have begun and whose actors are to be asked. The caller that asks them takes them out.
  [[nodiscard]] std::vector<std::size_t>& woken() { return woken_; }

  /// Holds a step that has been made until its declared cost has passed. Returns false if it has passed at `now`.
  [[nodiscard]] bool hold(std::size_t node, std::int64_t work, Time now);
  /// When the first held step passes; none where none is held.
  [[nodiscard]] std::optional<Time> held_until() const;
  /// Takes out the first held step, and returns its node.
  std::size_t release();
  [[nodiscard]] bool is_held(std::size_t node) const;

 private:
  struct Held {
    Time until;
    std::size_t node = 0;
  };

  std::vector<Node> nodes_;
  std::vector<Held> held_;  // the first to pass comes first
  std::vector<std::size_t> woken_;
  bool ended_ = false;
};

}  // namespace tactor
