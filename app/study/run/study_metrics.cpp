#include "app/study/run/study_metrics.hpp"

#include <fmt/format.h>

#include "framework/node/registry.hpp"

namespace tactor {

namespace {

/// A metric that a study asks for, and where.
struct AskedMetric {
  std::string name;
  std::string key;  ///< of the study
  SourceLocation place;
};

std::vector<AskedMetric> asked_metrics(const StudySpec& spec) {
  std::vector<AskedMetric> asked;
  for (std::size_t i = 0; i < spec.metrics.size(); ++i) {
    asked.push_back({spec.metrics[i], "metrics", spec.metric_places[i]});
  }
  if (spec.report == StudyReport::work_precision && spec.error_place) {
    asked.push_back({spec.error, "report.error", *spec.error_place});
  } else if (spec.report == StudyReport::work_precision) {
    asked.push_back({spec.error, "report: work_precision", spec.report_place});
  } else if (spec.report == StudyReport::stability) {
    asked.push_back({"stability.verdict", "report: stability", spec.report_place});
  }
  return asked;
}

/// Why no run reports the metric, or which name was meant.
std::string why_not_reported(const std::string& name, const RunMetrics& metrics, Registry& registry) {
  const auto left_out = metrics.left_out.find(name);
  if (left_out != metrics.left_out.end()) return ", which no run reports: " + left_out->second;
  std::vector<std::string> types;
  registry.load_all();
  for (const NodeInfo* info : registry.types()) {
    const auto is_it = [&](const MetricInfo& metric) { return metric.name == name; };
    // A type that stands for others is not met in a run.
    if (info->stand_in() == nullptr && std::any_of(info->metrics.begin(), info->metrics.end(), is_it))
      types.push_back(info->type);
  }
  if (!types.empty()) {
    return fmt::format(", which no run reports: no graph has a node of the type {}", fmt::join(types, " or "));
  }
  std::vector<std::string> names;
  for (const auto& [one, info] : metrics.reported) names.push_back(one);
  return did_you_mean(name, names);
}

}  // namespace

void check_metrics(const StudySpec& spec, const RunMetrics& metrics, Registry& registry) {
  Diagnostics diagnostics;
  for (const AskedMetric& asked : asked_metrics(spec)) {
    const auto found = metrics.reported.find(asked.name);
    if (found == metrics.reported.end()) {
      diagnostics.error(asked.place,
                        fmt::format("{}: expected a metric that a run of the study reports, found {}{}", asked.key,
                                    asked.name, why_not_reported(asked.name, metrics, registry)));
    } else if (asked.key == "report.error" && found->second.better == Better::neither) {
      diagnostics.error(asked.place, fmt::format("report.error: expected a metric with a direction, "
                                                 "found {}, for which neither lower nor higher is better",
                                                 asked.name));
    }
  }
  diagnostics.throw_if_any();
}

}  // namespace tactor
