// What a run whose clock is real tells beside the others: its latencies and the metrics of its real-time lanes.
#pragma once

#include <string>

#include "app/run/run.hpp"
#include "framework/engine/engine_status.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// The histograms of the latencies as CSV, from which metrics of several runs are put together: `latency` (NODE.wakeup,
/// NODE.body, NODE.end_to_end, or the age on an edge by its name), `us`, the middle of a bucket at most 1/64 wide, and
/// `count`.
std::string latencies_csv(const Plan& plan, const EngineStatus& status);

/// device.{ticks,missed,wakeup_us.*,body_us.*,allocations,page_faults,dropped} and end_to_end_us.* of each node in the
/// real-time lane, record_drops and stalls.
void report_live(const Plan& plan, const EngineStatus& status, std::uint64_t record_dropped, Report& report);

/// follow.*
void report_follower(const FollowerFigures& figures, Report& report);

}  // namespace tactor
