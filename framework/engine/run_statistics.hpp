// The metrics that an engine keeps of the nodes and edges of a run.
#pragma once

#include <cstdint>

#include "framework/core/time.hpp"
#include "framework/realtime/latency_histogram.hpp"

namespace tactor {

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
