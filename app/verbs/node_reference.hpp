// The reference of node types, from their declarations: for the terminal and as Markdown for docs/.
#pragma once

#include <string>
#include <vector>

#include "framework/node/info.hpp"

namespace tactor {

/// One line a type.
std::string node_list(const std::vector<const NodeInfo*>& types);
/// Everything about a metric, for the terminal.
std::string metric_help(const MetricInfo& metric);
/// Everything about one type, for the terminal.
std::string node_help(const NodeInfo& info);
/// Everything about all types, as Markdown.
std::string node_reference_markdown(const std::vector<const NodeInfo*>& types);

}  // namespace tactor
