// What a run whose clock is real leaves: its recording, its metrics, and its costs for a replay under the virtual
// clock.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "framework/engine/live/live_status.hpp"
#include "framework/engine/run_observer.hpp"
#include "framework/graph/plan.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

/// Passes messages to the recorder and keeps what steps cost.
class LiveWatch final : public RunObserver {
 public:
  /// `recorder` may be null; it has the plan's streams.
  LiveWatch(const Plan& plan, Recorder* recorder, bool keep_costs);
  void on_message(std::size_t stream, const Stamp& stamp, const void* payload) override;
  void on_step(std::size_t node, Time now, Duration cost) override;

  /// True where the recorder has thrown: it takes nothing more.
  [[nodiscard]] bool failed() const { return failed_; }
  /// By node: the time of each step and what it cost, in the order in which they ended.
  [[nodiscard]] const std::vector<std::vector<std::pair<Time, Duration>>>& costs() const { return costs_; }

 private:
  Recorder* recorder_;
  const bool keep_costs_;
  bool failed_ = false;
  std::vector<std::vector<std::pair<Time, Duration>>> costs_;
};

/// Writes `folder`/costs/NODE.txt, the cost of each step in seconds, and `folder`/replay.yaml, the graph with
/// `clock: virtual`, these costs and the `duration` that was run. Throws RunError where that is not possible.
void write_replay(const Plan& plan, const LiveWatch& watch, const LiveStatus& status, Duration duration,
                  const std::filesystem::path& folder);

/// The histograms of the latencies as CSV, from which metrics of several runs are put together: `latency` (NODE.wakeup,
/// NODE.body, NODE.end_to_end, or the age on an edge by its name), `us`, the middle of a bucket at most 1/64 wide, and
/// `count`.
std::string latencies_csv(const Plan& plan, const LiveStatus& status);

/// device.{ticks,missed,wakeup_us.*,body_us.*,allocations,page_faults,dropped} and end_to_end_us.* of each node in the
/// real-time lane, record_drops and stalls.
void report_live(const Plan& plan, const LiveStatus& status, Report& report);

}  // namespace tactor
