// What a declaration says about a node type, as words: for help on the terminal and for the pages of the reference.
#pragma once

#include <string>

#include "framework/node/info.hpp"

namespace tactor {

/// The default of a parameter as a graph would say it, or `required`.
std::string value_text(const NodeInfo& info, const ParamInfo& param);
/// What a parameter takes: `integer`, `N/m`, `list of m`, `a | b`.
std::string kind_text(const ParamInfo& param);
/// `>= 0, <= 1`; empty where every value is allowed.
std::string bounds_text(const ParamInfo& param);
/// What a parameter means, and whether it may be set while a session runs.
std::string param_text(const ParamInfo& param);
/// Whether an input must be connected, whether it makes the node step, and its queue.
std::string trigger_text(const InputInfo& input);
/// What a metric is, and the runs that do not report it.
std::string metric_text(const MetricInfo& metric);
/// Where the node steps when the clock is real, unless the graph says otherwise.
std::string lane_text(const NodeInfo& info);
/// What it waits for before runs with it are judged, after a space; empty for nothing.
std::string warm_text(const NodeInfo& info);

}  // namespace tactor
