// The actors of a live run, one for each node outside of the real-time lane, and the threads of their lanes.
#pragma once

#include <caf/actor.hpp>
#include <caf/actor_system_config.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "framework/engine/live/lane_plan.hpp"
#include "framework/engine/live/lane_scheduler.hpp"

namespace tactor {

/// Its owner calls `end` after `make`, also if that has thrown.
class LaneActors {
 public:
  /// Makes threads and actors. `on_thread` is called on each thread before it works, `step` with a node that was asked,
  /// on a thread of its lane. Throws RunError if the system does not give all the threads.
  void make(const LanePlan& lanes, const LaneScheduler::OnThread& on_thread,
            const std::function<void(std::size_t node)>& step);
  /// Asks each of the nodes for a step.
  void ask(const std::vector<std::size_t>& nodes);
  /// Ends actors and threads, those that there are.
  void end();

 private:
  caf::actor_system_config config_;
  std::unique_ptr<caf::actor_system> system_;
  const caf::message step_message_ = caf::make_message(LaneActor::Step::value);  // one for all, so none is allocated
  std::vector<caf::actor> actors_;                                               // by node
};

}  // namespace tactor
