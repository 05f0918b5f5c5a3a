// A node in the real-time lane: its loop, the wait-free ways in and out, and the metrics of both.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "framework/engine/engine_status.hpp"
#include "framework/engine/lane_tick.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/periodic_loop.hpp"
#include "framework/realtime/ring.hpp"

namespace tactor {

/// Steps one node at its rate in a PeriodicLoop. A tick sees the messages that became visible by its deadline, as under
/// the virtual clock. In the tick nothing allocates, locks, logs or waits: messages come by the EdgeQueue of their
/// edge, into which the engine writes meanwhile, and what the node sends leaves by one Ring, which the engine drains.
class RealtimeLane {
 public:
  /// A message out of the loop.
  struct Out {
    std::size_t port = 0;  ///< index of the output
    Time valid;
    const std::byte* payload = nullptr;
  };

  /// `nodes`, its plan and `edges`, those into the node, must outlive the lane. `settings` are of its thread.
  RealtimeLane(PlanNodes& nodes, std::size_t node, const std::vector<std::size_t>& edges,
               const ThreadSettings& settings);

  /// From the engine, one thread at a time: a message for the input at which `edge` ends.
  void put(std::size_t edge, const Stamp& stamp, const void* payload);
  /// Parameters that hold from the next tick on; false where more wait than there is room for.
  [[nodiscard]] bool tune(std::shared_ptr<const void> params);
  /// True where a tick has begun with the newest of them. One thread at a time with `tune`.
  [[nodiscard]] bool is_tuned() const {
    return applied_.load(std::memory_order_acquire) == tunings_ended_ + tunings_.size();
  }
  void set_phase(Phase phase) { phase_.store(phase, std::memory_order_release); }

  /// Starts the thread, which ticks from `origin` on.
  ThreadGrant start(Instant origin) { return loop_.start(origin); }
  /// Ends the loop; false where its body has not come back within `patience`. Then the lane must not be destroyed.
  [[nodiscard]] bool stop(Duration patience) { return loop_.stop(patience); }

  /// Takes what the next tick sent out of the loop; false where no further tick has ended. One thread at a time.
  [[nodiscard]] bool take_tick();
  /// What the tick taken last sent, in order; until the next call of `take_tick`.
  [[nodiscard]] const std::vector<Out>& sent() const { return sent_; }
  [[nodiscard]] const TickEvent& event() const { return event_; }
  [[nodiscard]] Time deadline() const { return deadline_; }

  [[nodiscard]] std::size_t node() const { return node_; }
  [[nodiscard]] const TickSchedule& schedule() const { return schedule_; }
  [[nodiscard]] const PeriodicLoop& loop() const { return loop_; }
  /// True where a tick of the stopping phase left the device at rest.
  [[nodiscard]] bool at_rest() const { return at_rest_.load(std::memory_order_acquire); }
  /// The age of the newest message at the input of `edge`, at each tick; null where the edge ends elsewhere.
  [[nodiscard]] const LatencyHistogram* age(std::size_t edge) const;
  [[nodiscard]] const LatencyHistogram& end_to_end() const { return *end_to_end_; }
  [[nodiscard]] std::uint64_t dropped_out() const { return out_->drops(); }

 private:
  /// One connected input.
  struct In {
    bool is_force = false;  // its stamps tell from which device sample a force was made
    Time newest_valid{INT64_MIN};
    std::unique_ptr<LatencyHistogram> age;
  };

  void tick(const Tick& tick);
  void take_in(In& in, EdgeQueue& queue, Time deadline);
  /// The index of an edge into the node; none where the edge ends elsewhere.
  [[nodiscard]] std::optional<std::size_t> input_of(std::size_t edge) const;

  PlanNodes& nodes_;
  const std::size_t node_;
  TickSchedule schedule_;
  LaneTick tick_;
  std::vector<In> inputs_;  // by edge of `tick_`
  std::unique_ptr<Ring> out_;
  Ring tuned_;                                       // pointers to parameters, into the loop
  std::deque<std::shared_ptr<const void>> tunings_;  // those whose tick has not come back, the oldest first
  std::uint64_t tunings_ended_ = 0;                  // taken out of `tunings_`
  std::atomic<std::uint64_t> applied_{0};
  std::vector<std::byte> out_payload_;
  std::vector<Out> sent_;  // of the tick that is being taken out
  CacheLines sent_payloads_;
  bool tick_taken_ = true;
  TickEvent event_;
  Time deadline_;
  std::unique_ptr<LatencyHistogram> end_to_end_;
  std::atomic<Phase> phase_{Phase::starting};
  std::atomic<bool> at_rest_{false};
  PeriodicLoop loop_;
};

}  // namespace tactor
