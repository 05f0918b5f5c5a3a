#include "app/run/run_metrics.hpp"

#include "framework/graph/plan_metrics.hpp"

namespace tactor {

namespace {

/// What the times of a method are divided by.
constexpr std::string_view result_count = "physics.steps";

void add_latency(std::vector<MetricInfo>& metrics, const std::string& name, const std::string& what, bool rare,
                 const std::string& missing) {
  const auto add = [&](const char* end, const char* which) {
    metrics.push_back({name + "." + end, "us", what + ", " + which, Better::lower, false, missing});
  };
  add("p50", "median");
  add("p99", "99th percentile");
  if (rare) {
    add("p99_9", "99.9th percentile");
    add("p99_99", "99.99th percentile");
  }
  add("max", "largest");
}

std::vector<MetricInfo> make_lane_metrics() {
  std::vector<MetricInfo> metrics{
      {"device.ticks", "1", "ticks of the loop", Better::neither},
      {"device.missed", "1", "ticks that were skipped because an earlier one took too long", Better::lower},
  };
  add_latency(metrics, "device.wakeup_us", "wake-up of the loop after its deadline", true, "");
  add_latency(metrics, "device.body_us", "time that a tick takes, of several nodes in one loop this one's part", false,
              "");
  metrics.push_back({"device.allocations", "1", "calls of the heap in the loop after its warm-up", Better::lower, false,
                     "calls of the heap cannot be counted"});
  metrics.push_back({"device.page_faults", "1", "page faults in the loop", Better::lower});
  metrics.push_back({"device.dropped", "1", "messages out of the loop that found its ring full", Better::lower});
  add_latency(metrics, "end_to_end_us",
              "from a sample of the device to the first force commanded that was made from it", false,
              "no commanded force was made from a sample of the device");
  return metrics;
}

/// Gives metrics the names that Report gives them.
class MetricNames {
 public:
  explicit MetricNames(MetricMap& named) : named_(named) {}

  void add(const std::string& node, const MetricInfo& metric) {
    if (metric.summed) return put(metric.name, metric);
    const auto [owner, fresh] = owners_.try_emplace(metric.name, node, metric.missing);
    if (owner->second.first.empty()) owner->second = {node, metric.missing};
    if (owner->second.first == node || node.empty()) return put(metric.name, metric);
    MetricInfo second = metric;
    // Where the first node does not report it, the second one has the plain name.
    if (second.missing.empty()) second.missing = owner->second.second;
    put(node + "." + metric.name, second);
  }

 private:
  void put(const std::string& name, MetricInfo metric) {
    metric.name = name;
    metric.left_out = nullptr;
    named_.try_emplace(name, std::move(metric));
  }

  MetricMap& named_;
  std::map<std::string, std::pair<std::string, std::string>> owners_;  // metric -> node, where it is missing
};

}  // namespace

const std::vector<MetricInfo>& program_metrics() {
  static const std::vector<MetricInfo> metrics{
      {"refits", "1", "fits of the coefficients of a predictor", Better::neither},
      {"fallbacks", "1", "predictions and ticks for which a method fell back to something simpler", Better::lower,
       true},
      {"drops", "1", "messages that queues dropped", Better::lower},
      {"warm_from_s", "s", "when the last of the nodes was warm", Better::neither, false,
       "a node is not warm when the run ends"},
      {"reference.rate_hz", "Hz",
       "how often the truth is known: results a second of the reference run or the recording", Better::neither, false,
       "nothing judges the run"},
  };
  return metrics;
}

const std::vector<MetricInfo>& live_metrics() {
  static const std::vector<MetricInfo> metrics{
      {"record_drops", "1", "messages that the recording could not take in time", Better::lower},
      {"stalled", "1", "nodes whose step had not come back within stall_timeout at the end", Better::lower},
  };
  return metrics;
}

const std::vector<MetricInfo>& follower_metrics() {
  static const std::string too_short = "nothing could be compared";
  static const std::vector<MetricInfo> metrics{
      {"follow.rms_error_N", "N", "RMS error against the reference that follows the run", Better::lower, false,
       too_short},
      {"follow.max_error_N", "N", "largest error against it", Better::lower, false, too_short},
      {"follow.delay_ms", "ms", "delay behind it in the last two seconds; positive: late", Better::near_zero, false,
       too_short + ", or the force was constant"},
      {"follow.compared_s", "s", "how much of the run was compared", Better::higher, false, too_short},
      {"follow.skipped_s", "s",
       "what of the run the reference skipped, because the machine was too slow for it, with the time in which it "
       "settled anew",
       Better::lower},
      {"follow.skips", "1", "how often it skipped", Better::lower},
      {"follow.dropped", "1", "messages that were lost on their way to it", Better::lower},
  };
  return metrics;
}

const std::vector<MetricInfo>& lane_metrics() {
  static const std::vector<MetricInfo> metrics = make_lane_metrics();
  return metrics;
}

const std::vector<MetricInfo>& run_time_metrics() {
  static const std::vector<MetricInfo> metrics{
      {"cpu_ms_per_s", "ms/s", "CPU time of the run per second of the graph's clock", Better::lower},
      {"method_us_per_result", "us", "CPU time of prediction, interpolation and force fields per physics result",
       Better::lower},
      {"method_us_per_tick", "us", "CPU time of prediction, interpolation and force fields per tick of the device",
       Better::lower},
  };
  return metrics;
}

MetricInfo step_time_metric(const std::string& node) {
  return {"cost_us." + node + ".median", "us", "CPU time of a step of " + node + ", median", Better::lower};
}

void RunMetrics::add(const RunMetrics& other) {
  reported.insert(other.reported.begin(), other.reported.end());
  left_out.insert(other.left_out.begin(), other.left_out.end());
  for (const auto& [name, metric] : reported) left_out.erase(name);
}

RunMetrics run_metrics(const Plan& plan, bool reference, bool followed) {
  RunMetrics metrics;
  MetricNames names(metrics.reported);
  for (const MetricInfo& metric : program_metrics()) names.add("", metric);
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const NodeMetrics mine = node_metrics(plan, n, reference);
    for (const MetricInfo& metric : mine.reported) names.add(plan.nodes[n].name, metric);
    metrics.left_out.insert(mine.left_out.begin(), mine.left_out.end());
  }
  if (plan.graph.clock == Clock::real) {
    for (const NodeSpec& node : plan.nodes) {
      if (node.scheduling.lane != Lane::realtime) continue;
      for (const MetricInfo& metric : lane_metrics()) names.add(node.name, metric);
    }
    for (const MetricInfo& metric : live_metrics()) names.add("", metric);
    for (const MetricInfo& metric : followed ? follower_metrics() : std::vector<MetricInfo>{}) names.add("", metric);
  }
  for (const auto& [name, metric] : metrics.reported) metrics.left_out.erase(name);
  return metrics;
}

RunMetrics run_times(const Plan& plan) {
  RunMetrics metrics;
  for (const MetricInfo& metric : run_time_metrics()) metrics.reported.emplace(metric.name, metric);
  bool has_device = false, counts_results = false;
  for (const NodeSpec& node : plan.nodes) {
    has_device = has_device || node.info->role == Role::device;
    for (const MetricInfo& declared : node.info->metrics) {
      counts_results = counts_results || declared.name == result_count;
    }
    MetricInfo metric = step_time_metric(node.name);
    std::string name = metric.name;
    metrics.reported.emplace(std::move(name), std::move(metric));
  }
  const auto leave_out = [&metrics](const char* name, const char* why) {
    metrics.reported.erase(name);
    metrics.left_out.emplace(name, why);
  };
  if (!has_device) leave_out("method_us_per_tick", "no node of the graph is a device");
  if (!counts_results) leave_out("method_us_per_result", "no node of the graph counts the results of the physics");
  return metrics;
}

bool is_method(Role role) {
  return role == Role::prediction || role == Role::interpolation || role == Role::force_field;
}

std::string unit_text(const std::string& unit) {
  if (unit == "1") return {};
  std::string text = unit;
  for (std::size_t at = text.find("^2"); at != std::string::npos; at = text.find("^2", at)) text.replace(at, 2, "²");
  return text;
}

std::string better_text(Better better) {
  return better == Better::neither ? std::string() : std::string(name_of(better));
}

double compared_value(Better better, double value) {
  return better == Better::near_zero ? std::abs(value) : value;
}

double badness(Better better, double value) {
  const double compared = compared_value(better, value);
  return better == Better::higher ? -compared : compared;
}

std::string_view direction_mark(Better better) {
  switch (better) {
    case Better::lower:
      return " ↓";
    case Better::higher:
      return " ↑";
    case Better::near_zero:
      return " →0";
    case Better::neither:
      return "";
  }
  return "";
}

}  // namespace tactor
