// What each step of a live run took, kept until the run is looked at.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "framework/engine/dispatcher.hpp"

namespace tactor {

/// The dispatcher tells each step under the engine's lock; one other thread takes what was told.
class StepTimes {
 public:
  /// `plan` outlives it.
  explicit StepTimes(const Plan& plan) : plan_(plan), times_(plan.nodes.size()) {}

  /// Keeps the times of all steps from now on. Once.
  void keep(Dispatcher& dispatcher) {
    dispatcher.add_step_tap(told_.emplace(message_type<StepEvent>(), Queue{QueuePolicy::drop_newest, most_told}));
  }
  /// Takes what was told since the last call.
  void take() {
    if (!told_) return;
    told_->take_all([this](const Stamp& stamp, const void* value) {
      const auto node = static_cast<std::size_t>(static_cast<const StepEvent*>(value)->node);
      if (plan_.nodes[node].scheduling.lane != Lane::realtime) times_[node].push_back(stamp.produced - stamp.valid);
    });
  }

  /// From the start of each step until its results were visible; none if they are not kept or in the real-time lane.
  [[nodiscard]] const std::vector<Duration>& of(std::size_t node) const { return times_[node]; }
  /// Times that were lost, because nobody took them for long.
  [[nodiscard]] std::uint64_t dropped() const { return told_ ? told_->dropped() : 0; }

 private:
  /// Steps whose times may wait until they are taken.
  static constexpr std::uint32_t most_told = 1U << 16U;

  const Plan& plan_;
  std::optional<Tap> told_;
  std::vector<std::vector<Duration>> times_;  // by node
};

}  // namespace tactor
