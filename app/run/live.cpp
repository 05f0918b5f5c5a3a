#include "app/run/live.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/output.hpp"
#include "app/run/run_metrics.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace fs = std::filesystem;

LiveWatch::LiveWatch(const Plan& plan, Recorder* recorder, bool keep_costs)
    : recorder_(recorder), keep_costs_(keep_costs), costs_(plan.nodes.size()) {}

void LiveWatch::on_message(std::size_t stream, const Stamp& stamp, const void* payload) {
  if (recorder_ == nullptr || failed_) return;
  try {
    recorder_->write(stream, stamp, payload);
  } catch (const RunError&) {
    failed_ = true;
    throw;
  }
}

void LiveWatch::on_step(std::size_t node, Time now, Duration cost) {
  if (keep_costs_) costs_[node].emplace_back(now, cost);
}

void write_replay(const Plan& plan, const LiveWatch& watch, const LiveStatus& status, Duration duration,
                  const fs::path& folder) {
  std::uint64_t lost = status.record_dropped;
  std::uint64_t missed = 0;
  for (const LiveDevice& device : status.devices) {
    lost += device.dropped;
    missed += device.missed;
  }
  if (lost > 0) {
    throw RunError("no replay is written: " + std::to_string(lost) +
                   " messages of the run were lost on their way to the recording, its costs perhaps among them");
  }
  const fs::path costs = fs::absolute(folder) / "costs";
  std::error_code error;
  fs::create_directories(costs, error);
  GraphSpec graph = plan.graph;
  graph.clock = Clock::virtual_;
  graph.duration = std::max(duration, Duration{1});  // of a run that was ended before its first tick
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    std::vector<std::pair<Time, Duration>> steps = watch.costs()[n];
    std::sort(steps.begin(), steps.end());
    // What a step that had not passed at the end has cost is not known, except that it was more than was left.
    steps.emplace_back(Time{} + graph.duration, graph.duration);
    std::string text = "# what each step of " + plan.nodes[n].name +
                       " took, in s; the last line is of a step that had not passed at the end\n";
    for (const auto& [now, cost] : steps)
      text += fmt::format("{}.{:09}\n", cost.ns / 1'000'000'000, cost.ns % 1'000'000'000);
    const fs::path file = costs / (plan.nodes[n].name + ".txt");
    write_file(file, text);
    for (NodeSpec& node : graph.nodes) {
      if (node.name != plan.nodes[n].name) continue;
      node.cost = {};
      node.cost.kind = CostModel::Kind::trace;
      node.cost.trace_file = file;
    }
  }
  std::string note;
  if (missed > 0) {
    note = fmt::format(
        "# The loop of a device missed {} ticks, which this replay makes: from the first on it is another run.\n",
        missed);
  }
  write_file(folder / "replay.yaml", note + to_yaml(graph));
}

std::string latencies_csv(const Plan& plan, const LiveStatus& status) {
  std::string text = "latency,us,count\n";
  const auto add = [&text](const std::string& name, const LatencyStatistics& metrics) {
    for (const auto& [middle, count] : metrics.counts) {
      text += fmt::format("{},{:.3f},{}\n", name, middle.microseconds(), count);
    }
  };
  for (const LiveDevice& device : status.devices) {
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

void report_live(const Plan& plan, const LiveStatus& status, Report& report) {
  for (const LiveDevice& device : status.devices) {
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
  report.set("record_drops", static_cast<double>(status.record_dropped));
  report.set("stalled", static_cast<double>(std::count_if(status.nodes.begin(), status.nodes.end(),
                                                          [](const LiveNode& node) { return node.stalled; })));
}

}  // namespace tactor
