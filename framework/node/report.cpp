#include "framework/node/report.hpp"

#include <algorithm>
#include <functional>
#include <optional>

#include "framework/core/check.hpp"
#include "framework/node/info.hpp"
#include "framework/node/node.hpp"

namespace tactor {

void Report::begin(std::string node, const std::vector<MetricInfo>& metrics) {
  node_ = std::move(node);
  declared_.clear();
  for (const MetricInfo& metric : metrics) declared_.emplace(metric.name, metric.summed);
}

void Report::ask(const Node& node, std::string name, const std::vector<MetricInfo>& metrics) {
  begin(std::move(name), metrics);
  for (const MetricInfo& metric : metrics) {
    const std::optional<double> value = metric.value ? metric.value(node) : std::nullopt;
    if (value) metric.summed ? add(metric.name, *value) : set(metric.name, *value);
  }
  node.report(*this);
}

void Report::set(std::string_view name, double value) {
  demand_declared(name, false);
  std::string& owner = owners_.try_emplace(std::string(name), node_).first->second;
  if (owner.empty()) owner = node_;
  slot(owner == node_ || node_.empty() ? std::string(name) : node_ + "." + std::string(name)) = value;
}

void Report::add(std::string_view name, double value) {
  demand_declared(name, true);
  slot(name) += value;
}

void Report::add_series(Series series) {
  const auto same = [&series](const Series& s) { return s.name == series.name; };
  if (std::any_of(series_.begin(), series_.end(), same)) series.name = node_ + "." + series.name;
  series_.push_back(std::move(series));
}

void Report::demand_declared(std::string_view name, bool summed) const {
  const auto declared = declared_.find(name);
  if (declared != declared_.end() && declared->second == summed) return;
  const std::string who = node_.empty() ? "the program" : "node " + node_;
  const std::string what = who + " reports the metric " + std::string(name);
  if (declared == declared_.end()) {
    throw RunError(what + ", which its type does not declare, or declares as left out here; correct the declaration");
  }
  throw RunError(what +
                 (summed ? " by adding to it, and its type does not declare it as a sum"
                         : " by setting it, and its type declares it as a sum") +
                 "; correct the declaration");
}

double& Report::slot(std::string_view name) {
  for (auto& [key, value] : metrics_) {
    if (key == name) return value;
  }
  return metrics_.emplace_back(name, 0.0).second;
}

}  // namespace tactor
