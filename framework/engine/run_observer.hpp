// What a run tells those who watch it, and the metrics it keeps of its nodes and edges.
#pragma once

#include <cstddef>
#include <cstdint>

#include "framework/core/message.hpp"
#include "framework/realtime/latency_histogram.hpp"

namespace tactor {

/// Watches a run. The default watches nothing. Both engines call it from the thread that called `run`.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  /// A message of a recorded output became visible.
  virtual void on_message(std::size_t stream, const Stamp& stamp, const void* payload) {
    static_cast<void>(stream), static_cast<void>(stamp), static_cast<void>(payload);
  }
  /// A message arrived at a sink's `reference` input.
  virtual void on_reference(std::size_t edge, const Stamp& stamp, const void* payload) {
    static_cast<void>(edge), static_cast<void>(stamp), static_cast<void>(payload);
  }
  /// A node stepped at `now`. Under the virtual clock `cost` is the model's and steps come in order of `now`; live it
  /// is the time until the results were visible, and steps come in the order in which they ended.
  virtual void on_step(std::size_t node, Time now, Duration cost) {
    static_cast<void>(node), static_cast<void>(now), static_cast<void>(cost);
  }
  /// Called about every 10 ms of virtual time, live a few times a second; false ends the run there.
  virtual bool on_progress(Time now) {
    static_cast<void>(now);
    return true;
  }
};

/// What a node did in a run.
struct NodeStatistics {
  std::uint64_t steps = 0;
  std::uint64_t missed_ticks = 0;
  LatencyHistogram cpu;  ///< CPU time of the steps that were measured
  Duration cpu_total;    ///< their sum

  void add_cpu(Duration step) {
    cpu.record(step);
    cpu_total += step;
  }
};

/// What an edge carried in a run.
struct EdgeStatistics {
  std::uint64_t delivered = 0;
  std::uint64_t dropped = 0;
  std::uint64_t superseded = 0;  ///< replaced on a `latest` edge before its reader looked
};

}  // namespace tactor
