// The state of a run: what its nodes, edges and real-time lanes did so far.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "framework/engine/run_statistics.hpp"
#include "framework/node/node.hpp"
#include "framework/realtime/latency_histogram.hpp"

namespace tactor {

/// Percentiles of a latency.
struct LatencyStatistics {
  std::uint64_t count = 0;
  Duration p50, p99, p99_9, p99_99, max;
  /// The histogram behind them, so that runs can be put together: see LatencyHistogram::counts. Empty while it goes on.
  std::vector<std::pair<Duration, std::uint64_t>> counts;
};

/// The metrics of a histogram, all of one moment though its writer may go on; `whole` with its counts.
inline LatencyStatistics metrics_of(const LatencyHistogram& counting, bool whole) {
  const LatencyHistogram h(counting);  // NOLINT(performance-unnecessary-copy-initialization): the moment
  LatencyStatistics f{h.count(), h.quantile(0.5), h.quantile(0.99), h.quantile(0.999), h.quantile(0.9999), h.max(), {}};
  if (whole) f.counts = h.counts();
  return f;
}

/// An edge of a run.
struct EdgeStatus {
  EdgeStatistics metrics;
  /// Live: of the newest message that a step saw, from when it became visible to when the step began.
  LatencyStatistics age;
};

/// A node of a run.
struct NodeStatus {
  std::uint64_t steps = 0;
  std::uint64_t missed_ticks = 0;
  bool stalled = false;  ///< live: its step has not come back for longer than the graph's stall_timeout
  bool failed = false;   ///< live: its step has thrown
};

/// A node in the real-time lane. What nodes of one loop share is the same for each: all but `body_*` and `end_to_end`.
struct DeviceStatus {
  std::size_t node = 0;  ///< index into the plan
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;
  LatencyStatistics wake_latency;  ///< wake-up minus deadline
  LatencyStatistics body_time;     ///< the node's part of one tick: read, evaluate, gate, write, hand on
  Duration body_sum;
  LatencyStatistics end_to_end;             ///< device sample to the first commanded force that was made from it
  std::optional<std::uint64_t> heap_calls;  ///< in the loop, after its warm-up; none where they cannot be counted
  std::uint64_t page_faults = 0;
  std::uint64_t dropped = 0;  ///< messages out of the loop that found its ring full
};

/// The state of a run.
struct EngineStatus {
  Time now;
  Phase phase = Phase::starting;
  std::vector<std::string> waiting_for;  ///< nodes whose first step keeps the devices disengaged
  std::vector<NodeStatus> nodes;         ///< by index into the plan
  std::vector<EdgeStatus> edges;         ///< by index into the plan
  std::vector<DeviceStatus> devices;     ///< live: the nodes in the real-time lane
  std::vector<std::string> missing;      ///< privileges that were asked for and refused, each with its remedy
};

}  // namespace tactor
