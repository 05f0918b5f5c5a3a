// A node in a loop of the real-time lane: its part of a tick, the wait-free ways into it, and its metrics.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <vector>

#include "framework/engine/lane_tick.hpp"
#include "framework/engine/live/lane_flight.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/loop_statistics.hpp"
#include "framework/realtime/ring.hpp"
#include "framework/realtime/tick_loop.hpp"

namespace tactor {

/// Steps the node in the ticks of its loop. A tick sees the messages that became visible by its deadline, as under the
/// virtual clock. In the tick nothing allocates, locks, logs or waits. Messages come by the EdgeQueue of their edge:
/// the engine writes into that of an outer edge meanwhile, and only the loop into that of an inner one.
class LaneNode {
 public:
  /// The port of the TickEvent that ends what a tick of a node sends.
  static constexpr std::int32_t tick_done = -1;

  /// `nodes` and its plan must outlive it. Its outputs have the ports from `first_port` on. Throws InputError where
  /// more edges end at the node than a TickEvent tells of. Each tick is told to `flight`; null: to nobody.
  LaneNode(PlanNodes& nodes, std::size_t node, const std::vector<bool>& inner, std::size_t first_port,
           FlightRing* flight = nullptr);

  // The engine, one thread at a time.

  /// Before the loop starts: see LaneTick::count_from.
  void count_from(const Dispatcher& started) { tick_.count_from(started); }
  /// A message for the input at which `edge` ends; of an inner edge only before the loop starts.
  void put(std::size_t edge, const Stamp& stamp, const void* payload);
  /// Parameters that hold from the next tick on; false where more wait than there is room for.
  [[nodiscard]] bool tune(std::shared_ptr<const void> params);
  /// True where a tick has begun with the newest of them.
  [[nodiscard]] bool is_tuned() const {
    return applied_.load(std::memory_order_acquire) == tunings_ended_ + tunings_.size();
  }

  // The loop.

  /// Steps the node, and pushes what it sends and a TickEvent.
  void tick(const Tick& tick, Phase phase, Ring& out);
  /// The time that its part of a tick took.
  void took(Duration time) {
    body_time_->record(time);
    body_ns_.add(time.ns);
  }
  /// Tells the flight recorder of the tick that has just ended; `woke` is when the loop woke for it.
  void tell_flight(const Tick& tick, Instant woke, Duration body) {
    if (flight_) flight_->ended(tick.deadline, woke, body);
  }
  /// The node has thrown, and does not step again.
  void fail(std::exception_ptr thrown) {
    failure_ = std::move(thrown);
    failed_.store(true, std::memory_order_release);
  }

  // Any thread.

  [[nodiscard]] std::size_t node() const { return node_; }
  [[nodiscard]] bool has_failed() const { return failed_.load(std::memory_order_acquire); }
  /// What it threw; null where `fail` was not called.
  [[nodiscard]] std::exception_ptr failure() const { return has_failed() ? failure_ : nullptr; }
  /// True where a tick of the stopping phase left the device at rest.
  [[nodiscard]] bool at_rest() const { return at_rest_.load(std::memory_order_acquire); }
  /// The age of the newest message at the input of `edge`, at each tick; null where the edge ends elsewhere.
  [[nodiscard]] const LatencyHistogram* age(std::size_t edge) const;
  [[nodiscard]] const LatencyHistogram& end_to_end() const { return *end_to_end_; }
  [[nodiscard]] const LatencyHistogram& body_time() const { return *body_time_; }
  [[nodiscard]] Duration body_sum() const { return {body_ns_.value()}; }

 private:
  /// One connected input.
  struct In {
    bool is_force = false;  // its stamps tell from which device sample a force was made
    Time newest_valid{INT64_MIN};
    std::unique_ptr<LatencyHistogram> age;
  };

  void take_in(In& in, EdgeQueue& queue, Time deadline);
  /// The index of an edge into the node; none where the edge ends elsewhere.
  [[nodiscard]] std::optional<std::size_t> input_of(std::size_t edge) const;

  PlanNodes& nodes_;
  const std::size_t node_;
  const std::size_t first_port_;
  LaneTick tick_;
  std::optional<LaneFlight> flight_;                 // none: nothing is recorded
  std::vector<In> inputs_;                           // by edge of `tick_`
  Ring tuned_;                                       // pointers to parameters, into the loop
  std::deque<std::shared_ptr<const void>> tunings_;  // those whose tick has not come back, the oldest first
  std::uint64_t tunings_ended_ = 0;                  // taken out of `tunings_`
  std::atomic<std::uint64_t> applied_{0};
  std::unique_ptr<LatencyHistogram> end_to_end_;
  std::unique_ptr<LatencyHistogram> body_time_;
  LoopCounter body_ns_;
  std::atomic<bool> at_rest_{false};
  std::exception_ptr failure_;  // read by others after `failed_` alone
  std::atomic<bool> failed_{false};
};

}  // namespace tactor
