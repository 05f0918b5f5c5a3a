// A CAF scheduler with lanes: each is a queue of its own, worked on by threads with a policy of their own.
#pragma once

#include <caf/actor_clock.hpp>
#include <caf/actor_system.hpp>
#include <caf/event_based_actor.hpp>
#include <caf/execution_unit.hpp>
#include <caf/scheduler/abstract_coordinator.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
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

/// The clock of a system without timeouts and delayed messages. CAF's own one hands every actor's end to a thread of
/// its own, over a queue of 63 entries that blocks when it is full. There is nothing here for such a thread to do.
class NoTimeouts final : public caf::actor_clock {
 public:
  void set_ordinary_timeout(time_point t, caf::abstract_actor* self, caf::atom_value type, std::uint64_t id) override;
  void set_multi_timeout(time_point t, caf::abstract_actor* self, caf::atom_value type, std::uint64_t id) override;
  void set_request_timeout(time_point t, caf::abstract_actor* self, caf::message_id id) override;
  void cancel_ordinary_timeout(caf::abstract_actor* self, caf::atom_value type) override;
  void cancel_request_timeout(caf::abstract_actor* self, caf::message_id id) override;
  void cancel_timeouts(caf::abstract_actor* self) override;
  void schedule_message(time_point t, caf::strong_actor_ptr receiver, caf::mailbox_element_ptr content) override;
  void schedule_message(time_point t, caf::group target, caf::strong_actor_ptr sender, caf::message content) override;
  void cancel_all() override;
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

  /// Makes the threads. Throws nothing, because CAF's system cannot be left half made: see `refused`.
  void start() override;
  void stop() override;
  void enqueue(caf::resumable* job) override;
  /// Why the system did not give all the threads; none where it did. After the actor system has been made.
  [[nodiscard]] const std::optional<std::string>& refused() const { return refused_; }
  NoTimeouts& clock() noexcept override { return clock_; }

 private:
  struct Lane;
  class Worker;

  OnThread on_thread_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  std::optional<std::string> refused_;
  NoTimeouts clock_;
};

}  // namespace tactor
