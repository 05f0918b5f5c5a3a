// The metrics of a run, known before it: those of its nodes, and those that the program itself adds.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

/// The version of what metrics mean: raised with every change of a definition, so that no table is compared with one of
/// another meaning unseen. docs/reference/metrics.md has the definitions.
inline constexpr int metric_definitions = 5;

/// Of every run: refits, fallbacks, drops, warm_from_s, reference.rate_hz.
const std::vector<MetricInfo>& program_metrics();
/// Of every run whose clock is real: record_drops, stalled.
const std::vector<MetricInfo>& live_metrics();
/// Of such a run that a reference follows: follow.*.
const std::vector<MetricInfo>& follower_metrics();
/// Of each node in the real-time lane of such a run: device.* and end_to_end_us.*.
const std::vector<MetricInfo>& lane_metrics();
/// Run times, which tables derive from the costs of nodes: cpu_ms_per_s, method_us_per_result, method_us_per_tick.
const std::vector<MetricInfo>& run_time_metrics();
/// The median time of a step of the node: cost_us.NODE.median.
MetricInfo step_time_metric(const std::string& node);

/// Metrics by their names in a run.
using MetricMap = std::map<std::string, MetricInfo, std::less<>>;

/// What runs report.
struct RunMetrics {
  MetricMap reported;                                        ///< those with `missing` where no such thing happens
  std::map<std::string, std::string, std::less<>> left_out;  ///< declared by a node and not reported: why

  /// Adds what other runs report. A metric that some runs report is not left out.
  void add(const RunMetrics& other);
};

/// What a run of the plan reports; `reference`: it is compared with its reference run, where a sink asks for one.
RunMetrics run_metrics(const Plan& plan, bool reference, bool followed = false);

/// The run times that tables derive from a run of the plan.
RunMetrics run_times(const Plan& plan);

/// True for a node whose steps are the method under study: it makes the force between results of the physics.
bool is_method(Role role);

/// A unit as tables show it, `N/ms²`; empty for a plain number.
std::string unit_text(const std::string& unit);
/// `lower`, `higher`, or empty where neither is better.
std::string better_text(Better better);
/// The value; of a metric that is better near zero its size.
double compared_value(Better better, double value);
/// A number that is smaller for a better value; the value itself where neither is better.
double badness(Better better, double value);
/// ` ↓` where lower is better, ` ↑` where higher is, else empty.
std::string_view direction_mark(Better better);

}  // namespace tactor
