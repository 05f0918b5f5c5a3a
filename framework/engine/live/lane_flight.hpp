// What the flight recorder is told of a node in the real-time lane.
#pragma once

#include <algorithm>
#include <cstddef>

#include "framework/core/messages.hpp"
#include "framework/engine/live/finite_watch.hpp"
#include "framework/realtime/flight_ring.hpp"

namespace tactor {

/// One record a tick, and an event where the node begins to send values that are not finite. In the loop: allocates,
/// locks and waits for nothing.
class LaneFlight {
 public:
  /// More numbers than that in a message are not looked at.
  static constexpr std::size_t most_numbers = 128;

  /// `period` is that of the loop.
  LaneFlight(const FlightWriter& writer, const NodeInfo& info, bool is_device, Duration period)
      : writer_(writer), info_(info), is_device_(is_device), period_(period), watch_(info.outputs, most_numbers) {}

  /// Where a device tells of the tick; null for another node.
  [[nodiscard]] FlightDevice* device() { return is_device_ ? &device_ : nullptr; }
  void age(std::size_t input, Duration age) {
    if (input < FlightTick::most_inputs) tick_.input_age_s[input] = static_cast<float>(age.seconds());
  }
  void sent(std::size_t output, const void* value) { watch_.look(output, value); }
  /// The tick with that deadline has ended; its loop woke at `woke`, and the step took `body`.
  void ended(Time deadline, Instant woke, Duration body) noexcept {
    const Instant due = writer_.ring->origin() + (deadline - Time{});
    // From the first deadline that has no tick: a loop that woke late makes one for the last of them.
    const Instant first_due = last_due_ == Instant{} ? due : std::min(due, last_due_ + period_);
    last_due_ = due;
    const auto lateness = static_cast<float>((woke - first_due).seconds()), took = static_cast<float>(body.seconds());
    if (is_device_) {
      device_.lateness_s = lateness;
      device_.body_s = took;
      writer_.ring->add(FlightKind::device, writer_.node, due, device_);
      if (device_.engagement == static_cast<std::uint8_t>(Engagement::fault)) writer_.ring->note_fault();
    } else {
      tick_.lateness_s = lateness;
      tick_.body_s = took;
      writer_.ring->add(FlightKind::tick, writer_.node, due, tick_);
    }
    if (const auto output = watch_.take()) {
      writer_.ring->tell(FlightEvent::not_finite, writer_.node, due, info_.outputs[*output].name);
    }
  }

 private:
  const FlightWriter writer_;
  const NodeInfo& info_;
  const bool is_device_;
  const Duration period_;
  Instant last_due_;  // of the tick before; zero: there was none
  FiniteWatch watch_;
  FlightDevice device_;
  FlightTick tick_;
};

}  // namespace tactor
