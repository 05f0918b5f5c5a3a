// A loop of the real-time lane: the nodes of a chain, stepped one after the other, and the wait-free way out.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <vector>

#include "framework/engine/engine_status.hpp"
#include "framework/engine/live/lane_node.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/graph/chains.hpp"
#include "framework/realtime/periodic_loop.hpp"
#include "framework/realtime/ring.hpp"

namespace tactor {

/// Steps the nodes of a chain at their rate in a PeriodicLoop. In the tick nothing allocates, locks, logs or waits:
/// what the nodes send leaves by one Ring, which the engine drains. A node that throws does not step again; the others
/// go on, and the loop ends with the last.
class RealtimeLane {
 public:
  /// A message out of the loop.
  struct Out {
    std::size_t node = 0;
    std::size_t port = 0;  ///< index of its output
    Time valid;
    const std::byte* payload = nullptr;
  };

  /// `nodes` and its plan must outlive the lane. `chain` is an index into Chains::nodes; `settings` are of its thread.
  /// Its ticks are told to `flight`; null: to nobody.
  RealtimeLane(PlanNodes& nodes, const Chains& chains, std::size_t chain, const ThreadSettings& settings,
               FlightRing* flight = nullptr);

  /// A node of the chain, by its index into the plan.
  [[nodiscard]] LaneNode& operator[](std::size_t node) { return *nodes_[position_of(node)]; }
  [[nodiscard]] const LaneNode& operator[](std::size_t node) const { return *nodes_[position_of(node)]; }
  void set_phase(Phase phase) { phase_.store(phase, std::memory_order_release); }

  /// Before `start`: what the nodes have sent in their own `start` counts.
  void count_from(const Dispatcher& started) {
    for (const auto& node : nodes_) node->count_from(started);
  }
  /// Starts the thread, which ticks from `origin` on.
  ThreadGrant start(Instant origin) { return loop_.start(origin); }
  /// Ends the loop; false where its body has not come back within `patience`. Then the lane must not be destroyed.
  [[nodiscard]] bool stop(Duration patience) { return loop_.stop(patience); }

  /// Takes what the next tick of a node sent out of the loop; false where no further one has ended. The nodes of a tick
  /// come in the order in which they stepped. One thread at a time.
  [[nodiscard]] bool take_tick();
  /// What that tick sent, in order; until the next call of `take_tick`.
  [[nodiscard]] const std::vector<Out>& sent() const { return sent_; }
  [[nodiscard]] const TickEvent& event() const { return event_; }
  [[nodiscard]] Time deadline() const { return deadline_; }

  /// When the engine is to look for what the next tick sends.
  [[nodiscard]] Time next_look(Time now) const;
  [[nodiscard]] const PeriodicLoop& loop() const { return loop_; }
  /// The node whose step is under way; between two ticks the first of the chain.
  [[nodiscard]] std::size_t stepping() const { return nodes_[stepping_.load(std::memory_order_relaxed)]->node(); }
  /// What a node threw; null where it has not. Any thread.
  [[nodiscard]] std::exception_ptr failure(std::size_t node) const;
  [[nodiscard]] std::uint64_t dropped_out() const { return out_->drops(); }

 private:
  /// What a number of a record in the ring stands for.
  struct Port {
    std::size_t node = 0, output = 0;
  };

  void tick(const Tick& tick);
  [[nodiscard]] std::size_t position_of(std::size_t node) const;

  TickSchedule schedule_;
  std::vector<std::unique_ptr<LaneNode>> nodes_;  // in the order in which they step
  std::vector<Port> ports_;
  std::size_t left_;  // nodes that have not thrown, by the loop
  std::unique_ptr<Ring> out_;
  std::vector<std::byte> out_payload_;
  std::vector<Out> sent_;  // of the tick that is being taken out
  CacheLines sent_payloads_;
  bool tick_taken_ = true;
  TickEvent event_;
  Time deadline_;
  std::atomic<Phase> phase_{Phase::starting};
  std::atomic<std::size_t> stepping_{0};  // a position in `nodes_`
  Pace* const pace_;                      // of a node, in place of the schedule; null: none
  PeriodicLoop loop_;
};

}  // namespace tactor
