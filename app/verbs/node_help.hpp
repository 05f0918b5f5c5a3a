// Node types and metrics for the terminal, from their declarations.
#pragma once

#include <string>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

/// One line a type.
std::string node_list(const std::vector<const NodeInfo*>& types);
/// Everything about a metric.
std::string metric_help(const MetricInfo& metric);
/// Everything about one type.
std::string node_help(const NodeInfo& info);

}  // namespace tactor
