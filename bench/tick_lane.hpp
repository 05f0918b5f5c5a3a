// A device in the real-time lane, fed and drained as the engine does it, without the rest of an engine.
#pragma once

#include "framework/core/scheduling.hpp"
#include "framework/realtime/flight_ring.hpp"
#include "framework/realtime/latency_histogram.hpp"

namespace tactor::bench {

/// What runs of a lane have counted together.
struct LaneTimes {
  LatencyHistogram body;  ///< of a tick: take in, step, gate, hand out
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;
  std::uint64_t dropped = 0;    ///< messages that found the ring out of the loop full
  double engaged_share = 0;     ///< of the ticks: the gate let the wrench through
  std::int64_t heap_calls = 0;  ///< in the loop, after its warm-up
  std::int64_t page_faults = 0;
};

/// Runs a `device.simulated` with encoders at `rate` Hz for `duration`, its loop under `settings`; as in the graphs of
/// this project state, commanded and safety are wanted of its outputs. Meanwhile it gets a target each millisecond and
/// a force segment each 10 ms. `times` gets the metrics. The ticks are told to `flight`; null: to nobody.
void run_lane(double rate, Duration duration, const ThreadSettings& settings, LaneTimes& times,
              FlightRing* flight = nullptr);

}  // namespace tactor::bench
