// What nodes report after a run: metrics, curves and remarks.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "framework/core/time.hpp"

namespace tactor {

class Node;
struct MetricInfo;

/// A curve for plots: one value over time.
struct Series {
  std::string name;  ///< for example `commanded.x`
  std::string unit;
  std::vector<double> time;  ///< s
  std::vector<double> value;
};

/// Collects what the nodes of a run report: metrics under dotted names, curves, and remarks in words.
class Report {
 public:
  /// The following calls come from this node, which reports no other metrics than these. A metric or curve that another
  /// node has already set gets this node's name in front. An empty name is the program itself: a metric that it sets is
  /// its own until a node sets it.
  void begin(std::string node, const std::vector<MetricInfo>& metrics);
  /// The same, and takes what the node has of them: values that are bound to it, and what its report() sets.
  void ask(const Node& node, std::string name, const std::vector<MetricInfo>& metrics);
  /// Sets a metric. Throws RunError where the node does not declare it, or declares it as a sum.
  void set(std::string_view name, double value);
  /// Adds to a metric that is declared as a sum. Throws RunError where it is not.
  void add(std::string_view name, double value);
  void add_series(Series series);

  /// The metrics cover the run from this time on, when every node is warm (Node::warm_since); zero: the whole run.
  void judge_from(Time from) { judged_from_ = from; }
  [[nodiscard]] Time judged_from() const { return judged_from_; }

  /// Adds a remark in words, which names its subject: `iris_orca at ...: 3 timeouts, the last ...`.
  void remark(std::string text) { remarks_.push_back(std::move(text)); }

  [[nodiscard]] const std::vector<std::string>& remarks() const { return remarks_; }
  [[nodiscard]] const std::vector<std::pair<std::string, double>>& metrics() const { return metrics_; }
  [[nodiscard]] const std::vector<Series>& series() const { return series_; }

 private:
  void demand_declared(std::string_view name, bool summed) const;
  double& slot(std::string_view name);

  std::string node_;
  Time judged_from_;
  std::map<std::string, bool, std::less<>> declared_;       // by the node: metric -> it is a sum
  std::map<std::string, std::string, std::less<>> owners_;  // metric -> the node that set it
  std::vector<std::pair<std::string, double>> metrics_;
  std::vector<Series> series_;
  std::vector<std::string> remarks_;
};

}  // namespace tactor
