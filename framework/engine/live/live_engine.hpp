// The live engine: a run of a Plan in real time, one CAF actor a node, devices in loops beside them.
#pragma once

#include <mutex>
#include <thread>
#include <utility>

#include "framework/engine/engine.hpp"
#include "framework/engine/live/actor_steps.hpp"
#include "framework/engine/live/lane_actors.hpp"
#include "framework/engine/live/lane_plan.hpp"
#include "framework/engine/live/live_flight.hpp"
#include "framework/engine/live/priority_mutex.hpp"
#include "framework/engine/live/realtime_lane.hpp"
#include "framework/engine/live/stall_watch.hpp"
#include "framework/engine/live/step_times.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor {

/// The rules of the Dispatcher decide which node steps when and what it sees; the time is CLOCK_MONOTONIC since the
/// start. A step is made by the node's actor, in its lane, and passes when it is done: what it cost is what it took,
/// the way to the actor's thread included. So a run whose costs are recorded and given to the virtual clock as traces
/// takes the same steps with the same values.
///
/// Edges keep their queues in the dispatcher; a message between actors is only the request to step, and there is at
/// most one a node, so that no mailbox holds a backlog.
class LiveEngine final : public Engine, private ExternalInputs {
  /// Between making the threads and time zero.
  static constexpr Duration head_start{20'000'000};
  /// How often the timer thread watches for stalls, and the calling thread does what it has to do at the end.
  static constexpr Duration watch_period{20'000'000};
  /// How often it looks while a request waits for the one before.
  static constexpr Duration waiting_period{1'000'000};
  /// How long steps may take to come back at the end.
  static constexpr Duration longest_step_at_end{1'000'000'000};

 public:
  /// Throws as LiveLibrary::make.
  explicit LiveEngine(const Plan& plan, const EngineOptions& options = {});
  ~LiveEngine() override;

  void with_dispatcher(const std::function<void(Dispatcher&)>& work) override;
  [[nodiscard]] bool steps_on_caller() const override { return false; }
  bool feed(std::size_t node, std::optional<Time> valid, std::span<const FedValue> values) override;
  void set(std::size_t node, std::shared_ptr<const void> params, const SetEvent& event) override;
  [[nodiscard]] bool is_set(std::size_t node) override;
  void stop_when(std::function<bool()> asked) override { stop_asked_ = std::move(asked); }
  void start() override;
  void advance(Duration duration, const Attendance& attendance) override;
  [[nodiscard]] bool is_running() override;
  [[nodiscard]] Time now() override { return finished_ ? status_.now : clock(); }
  void stop(const std::string& why) override;
  void finish(const Attendance& attendance) override;
  [[nodiscard]] std::optional<std::string> failure() const override;
  [[nodiscard]] bool is_abandoned() const override { return abandoned_; }
  [[nodiscard]] PlanNodes& nodes() override { return nodes_; }
  [[nodiscard]] FlightFile* flight() override { return flight_.file(); }
  [[nodiscard]] EngineStatus status() override;
  [[nodiscard]] NodeStatistics node_statistics(std::size_t node) const override { return steps_[node].statistics; }
  [[nodiscard]] std::vector<Duration> step_times(std::size_t node) const override { return step_times_.of(node); }
  [[nodiscard]] EdgeStatistics edge_statistics(std::size_t edge) const override { return status_.edges[edge].metrics; }
  [[nodiscard]] std::uint64_t dropped() const override { return step_times_.dropped(); }
  [[nodiscard]] Duration cpu_time() const override;

 private:
  /// The thread that keeps the time.
  struct Timer {
    PriorityCondition condition;
    bool ended = false;
    Time waits_until;
    std::thread thread;
  };

  // What the dispatcher tells, under the lock.
  void on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) override;
  void on_phase(Phase phase) override;

  void make_lanes();
  void make_actors();
  void start_threads();
  void end_timer();
  /// Ends the timer thread, the actors and their lanes, those that there are.
  void end_threads();
  void granted(const ThreadGrant& grant);

  [[nodiscard]] Time clock() const { return Time{} + (MonotonicClock::now() - origin_); }
  [[nodiscard]] Time end() const { return Time{} + plan_.graph.duration; }
  // Under the lock:
  [[nodiscard]] Time next_instant() const;
  void catch_up(Time t);
  void handle_events_before(Time t);
  void begin_stop(bool failed);
  /// The loop that steps a node; null outside of the real-time lane.
  [[nodiscard]] RealtimeLane* loop_of(std::size_t node) const {
    return lanes_.chains.of[node] ? loops_[*lanes_.chains.of[node]].get() : nullptr;
  }
  /// `; it shares its loop with device`, of a node of a chain; else empty.
  [[nodiscard]] std::string shared_text(std::size_t node) const;
  void drain_loops();
  /// What a tick of a node in a loop sent becomes visible.
  void publish_tick(RealtimeLane& loop);
  [[nodiscard]] Time next_look(Time now) const;
  /// The run fails, because of a node where one is named.
  void fail(const std::string& why, std::optional<std::size_t> node = {});
  void look_for_stalls();
  void look_for_failure(std::size_t node);
  [[nodiscard]] std::int64_t steps_ended(std::size_t node) const;
  [[nodiscard]] std::vector<std::size_t> devices_not_at_rest() const;
  /// Nodes whose step has not come back.
  [[nodiscard]] std::vector<std::size_t> busy_nodes() const;
  void release_held();
  [[nodiscard]] EngineStatus counters() const;

  /// Adds the latencies to `counters`; `whole` with their histograms. Takes long and needs no lock.
  void add_latencies(EngineStatus& status, bool whole) const;
  /// Under the lock: asks the actors of nodes whose steps have begun, and wakes the timer thread for what comes next.
  void wake_others();
  void step(std::size_t node);
  void keep_time();
  /// Lets the owner of the run attend; returns false if a request waits. An exception is the run's failure.
  bool attend(const Attendance& attendance);
  /// The same until `done` or the time is over.
  void attend_until(const Attendance& attendance, Duration longest, const std::function<bool()>& done);

  const Plan& plan_;
  LiveFlight flight_;
  PlanNodes nodes_;
  std::optional<std::string> failure_;
  bool finished_ = false;
  bool abandoned_ = false;
  EngineStatus status_;  // at the end
  std::function<bool()> stop_asked_ = [] { return false; };
  StepTimes step_times_;
  LanePlan lanes_;
  std::vector<std::unique_ptr<LatencyHistogram>> age_;  // by edge, written by its reader's steps

  mutable PriorityMutex mutex_;  // while the run goes on, over all down to `missing_` but the thread of the timer
  Timer timer_;
  std::unique_ptr<Dispatcher> dispatcher_;
  ActorSteps steps_;
  StallWatch stalls_;
  std::vector<std::string> missing_;

  std::vector<std::unique_ptr<RealtimeLane>> loops_;  // by chain

  Instant origin_;
  std::optional<MemoryLock> memory_;
  LaneActors actors_;
};

}  // namespace tactor
