// The metrics that the nodes of a plan report, known before the run.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

/// The metrics that a planned node declares.
struct NodeMetrics {
  std::vector<MetricInfo> reported;                           ///< those with `missing` where no such thing happens
  std::vector<std::pair<std::string, std::string>> left_out;  ///< name, and why the node does not report it here
};

/// Those of the node of that index; `reference`: the run is compared with its reference run.
NodeMetrics node_metrics(const Plan& plan, std::size_t node, bool reference);

}  // namespace tactor
