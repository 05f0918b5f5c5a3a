// What runs report: the metrics of the nodes, and those that the program adds.
#include <fmt/format.h>

#include <map>
#include <set>

#include "app/run/run_metrics.hpp"
#include "app/verbs/node_texts.hpp"
#include "app/verbs/reference/pages.hpp"

namespace tactor {

void add_metric_table(const std::vector<MetricInfo>& metrics, PageWriter& page) {
  std::vector<std::vector<std::string>> rows;
  for (const MetricInfo& metric : metrics) {
    rows.push_back({code_span(metric.name), metric.unit == "1" ? "" : page.text(metric.unit),
                    metric.better == Better::neither ? "" : std::string(name_of(metric.better)),
                    page.text(metric_text(metric))});
  }
  page.table({"metric", "unit", "better", "meaning"}, rows);
}

void add_metric_page(const ReferenceSource& source, Pages& pages) {
  PageWriter page("metrics_list.md", "List of metrics", source.types);
  page.prose("Look up what a metric of a run means, in which unit it is, and which values are better.");
  page.code("sh", "tactor check --metrics wall/refit       # those that a run of this graph reports\n");
  page.markdown(fmt::format(
      "These are the definitions of version {}. {} tells how they are computed. Numbers have no unit where the table "
      "shows none.",
      metric_definitions, page.link("What the metrics mean", "metrics.md")));

  // Several node types may report the same metric: each stands once, under the types that report it.
  std::map<std::string, std::vector<std::string>> reporting;
  std::set<std::string> left;
  const auto key_of = [](const MetricInfo& metric) {
    return metric.name + "\n" + metric.unit + "\n" + metric_text(metric);
  };
  for (const NodeInfo* info : source.registry.types()) {
    for (const MetricInfo& metric : info->metrics) {
      reporting[key_of(metric)].push_back(info->type);
      left.insert(key_of(metric));
    }
  }
  std::map<std::vector<std::string>, std::vector<MetricInfo>> by_types;
  for (const NodeInfo* info : source.registry.types()) {
    for (const MetricInfo& metric : info->metrics) {
      const std::string key = key_of(metric);
      if (left.erase(key) > 0) by_types[reporting.at(key)].push_back(metric);
    }
  }
  for (const auto& [types, metrics] : by_types) {
    page.heading(2, fmt::format("{}", fmt::join(types, ", ")));
    add_metric_table(metrics, page);
  }

  page.heading(2, "Every run");
  add_metric_table(program_metrics(), page);
  page.heading(2, "A run whose clock is real");
  add_metric_table(live_metrics(), page);
  page.heading(3, "With `--follow`");
  add_metric_table(follower_metrics(), page);
  page.heading(3, "Of each node in the real-time lane");
  add_metric_table(lane_metrics(), page);
  page.heading(2, "Tables of a study or a comparison");
  std::vector<MetricInfo> run_times = run_time_metrics();
  run_times.push_back(step_time_metric("NODE"));
  add_metric_table(run_times, page);
  page.put_into(pages);
}

}  // namespace tactor
