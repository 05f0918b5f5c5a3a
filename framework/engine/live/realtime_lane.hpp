// A node in the real-time lane: its loop, the wait-free ways in and out, and the metrics of both.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "framework/engine/live/live_status.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/periodic_loop.hpp"
#include "framework/realtime/ring.hpp"

namespace tactor {

/// Steps one node at its rate in a PeriodicLoop. A tick sees the messages that became visible by its deadline, as under
/// the virtual clock. In the tick nothing allocates, locks, logs or waits: messages come by the EdgeQueue of their
/// edge, into which the engine writes meanwhile, and what the node sends leaves by one Ring, which the engine drains.
class RealtimeLane {
 public:
  /// A message or the end of a step, out of the loop.
  struct Out {
    std::int32_t port = 0;  ///< index of the output, or `step_done`
    Time valid;             ///< of the message; of `step_done` the time of the step
    const std::byte* payload = nullptr;
  };
  static constexpr std::int32_t step_done = -1;

  /// `nodes` and its plan must outlive the lane. `settings` are of its thread.
  RealtimeLane(PlanNodes& nodes, std::size_t node, const ThreadSettings& settings);

  /// From the engine, one thread at a time: a message for the input at which `edge` ends.
  void put(std::size_t edge, const Stamp& stamp, const void* payload);
  void set_phase(Phase phase) { phase_.store(phase, std::memory_order_release); }

  /// Starts the thread, which ticks from `origin` on.
  ThreadGrant start(Instant origin) { return loop_.start(origin); }
  /// Ends the loop; false where its body has not come back within `patience`. Then the lane must not be destroyed.
  [[nodiscard]] bool stop(Duration patience) { return loop_.stop(patience); }

  /// Takes the next message out of the loop; false where there is none. One thread.
  [[nodiscard]] bool take(Out& out);

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
    std::size_t edge = 0;
    InputBase* input = nullptr;
    bool is_force = false;  // its stamps tell from which device sample a force was made
    Time newest_valid{INT64_MIN};
    std::unique_ptr<LatencyHistogram> age;
  };

  void tick(const Tick& tick);
  void take_in(In& in, Time deadline);

  PlanNodes& nodes_;
  const std::size_t node_;
  TickSchedule schedule_;
  std::vector<In> inputs_;
  std::vector<OutputBase*> outputs_;
  std::unique_ptr<Ring> out_;
  std::vector<std::byte> out_payload_;
  std::unique_ptr<LatencyHistogram> end_to_end_;
  std::atomic<Phase> phase_{Phase::starting};
  std::atomic<bool> at_rest_{false};
  PeriodicLoop loop_;
};

}  // namespace tactor
