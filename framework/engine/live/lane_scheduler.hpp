// A CAF scheduler with lanes: each is a queue of its own, worked on by threads with a policy of their own.
#pragma once

#include <caf/actor_system.hpp>
#include <caf/detail/thread_safe_actor_clock.hpp>
#include <caf/event_based_actor.hpp>
#include <caf/execution_unit.hpp>
#include <caf/scheduler/abstract_coordinator.hpp>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "framework/engine/live/lane_plan.hpp"
#include "framework/engine/live/priority_mutex.hpp"

namespace tactor {

/// An actor that runs in one lane. Its one message asks it for a step.
class LaneActor final : public caf::event_based_actor {
 public:
  using Step = caf::atom_constant<caf::atom("step")>;

  LaneActor(caf::actor_config& config, std::size_t lane, std::function<void()> step);
  [[nodiscard]] std::size_t lane() const { return lane_; }
  caf::behavior make_behavior() override;

 private:
  std::size_t lane_;
  std::function<void()> step_;
};

/// CAF knows one scheduler a system, and its own ones treat all actors alike: they share workers, which poll with
/// sleeps between, and a plain send runs the receiver on the sender's worker. This one puts a LaneActor that got a
/// message into the queue of its lane, whoever sent it, and wakes one of the lane's threads. Other actors (CAF's own)
/// run in lane 0. There are no delayed messages: the engine keeps time itself.
class LaneScheduler final : public caf::scheduler::abstract_coordinator {
 public:
  /// Called on each thread before it works.
  using OnThread = std::function<void(const LaneSpec& lane)>;

  LaneScheduler(caf::actor_system& system, std::vector<LaneSpec> lanes, OnThread on_thread);
  ~LaneScheduler() override;

  void start() override;
  void stop() override;
  void enqueue(caf::resumable* job) override;
  caf::detail::thread_safe_actor_clock& clock() noexcept override { return clock_; }

 private:
  struct Lane;
  class Worker;

  OnThread on_thread_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  caf::detail::thread_safe_actor_clock clock_;
};

}  // namespace tactor
