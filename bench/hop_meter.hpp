// The time from one node or actor to the next, for messages that carry the instant at which they were sent.
#pragma once

#include <cstdint>

#include "framework/core/messages.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor::bench {

/// Measures messages from a sender to a receiver. The first ones warm caches and branch predictors up and do not count.
class HopMeter {
 public:
  static constexpr int warm_up = 100;

  /// The message to send, made as the last thing before it is sent: force.x is the time since the meter was made, ns.
  [[nodiscard]] Wrench message() const {
    return {{static_cast<double>((MonotonicClock::now() - epoch_).ns), 0, 0}, {}};
  }
  /// Called as the first thing where the message is received.
  void received(const Wrench& message) {
    const Duration since_epoch = MonotonicClock::now() - epoch_;
    if (++count_ > warm_up) latency_.record(since_epoch - Duration{static_cast<std::int64_t>(message.force.x)});
  }
  [[nodiscard]] const LatencyHistogram& latency() const { return latency_; }

 private:
  Instant epoch_ = MonotonicClock::now();
  int count_ = 0;
  LatencyHistogram latency_;
};

}  // namespace tactor::bench
