#include "app/run/live.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/run/run_metrics.hpp"

namespace tactor {

std::string latencies_csv(const Plan& plan, const EngineStatus& status) {
  std::string text = "latency,us,count\n";
  const auto add = [&text](const std::string& name, const LatencyStatistics& metrics) {
    for (const auto& [middle, count] : metrics.counts) {
      text += fmt::format("{},{:.3f},{}\n", name, middle.microseconds(), count);
    }
  };
  for (const DeviceStatus& device : status.devices) {
    const std::string& name = plan.nodes[device.node].name;
    add(name + ".wakeup", device.wake_latency);
    add(name + ".body", device.body_time);
    add(name + ".end_to_end", device.end_to_end);
  }
  for (std::size_t e = 0; e < status.edges.size(); ++e) add(plan.edges[e].spec.name(), status.edges[e].age);
  return text;
}

namespace {

void set_latency(Report& report, const std::string& name, const LatencyStatistics& metrics, bool rare) {
  report.set(name + ".p50", metrics.p50.microseconds());
  report.set(name + ".p99", metrics.p99.microseconds());
  if (rare) {
    report.set(name + ".p99_9", metrics.p99_9.microseconds());
    report.set(name + ".p99_99", metrics.p99_99.microseconds());
  }
  report.set(name + ".max", metrics.max.microseconds());
}

}  // namespace

void report_live(const Plan& plan, const EngineStatus& status, std::uint64_t record_dropped, Report& report) {
  for (const DeviceStatus& device : status.devices) {
    report.begin(plan.nodes[device.node].name, lane_metrics());
    report.set("device.ticks", static_cast<double>(device.ticks));
    report.set("device.missed", static_cast<double>(device.missed));
    set_latency(report, "device.wakeup_us", device.wake_latency, true);
    set_latency(report, "device.body_us", device.body_time, false);
    if (device.heap_calls) report.set("device.allocations", static_cast<double>(*device.heap_calls));
    report.set("device.page_faults", static_cast<double>(device.page_faults));
    report.set("device.dropped", static_cast<double>(device.dropped));
    if (device.end_to_end.count > 0) set_latency(report, "end_to_end_us", device.end_to_end, false);
  }
  report.begin("", live_metrics());
  report.set("record_drops", static_cast<double>(record_dropped));
  report.set("stalled", static_cast<double>(std::count_if(status.nodes.begin(), status.nodes.end(),
                                                          [](const NodeStatus& node) { return node.stalled; })));
}

void report_follower(const FollowerFigures& figures, Report& report) {
  report.begin("", follower_metrics());
  if (figures.error.compared > 0) {
    report.set("follow.rms_error_N", figures.error.rms_N);
    report.set("follow.max_error_N", figures.error.max_N);
    report.set("follow.compared_s", figures.error.covered.seconds());
  }
  if (figures.error.delay) report.set("follow.delay_ms", figures.error.delay->milliseconds());
  report.set("follow.skipped_s", figures.skipped.seconds());
  report.set("follow.skips", static_cast<double>(figures.skips));
  report.set("follow.dropped", static_cast<double>(figures.dropped));
  if (figures.failure) report.remark("the reference that followed the run ended: " + *figures.failure);
}

}  // namespace tactor
