#include "app/verbs/node_help.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/verbs/node_texts.hpp"

namespace tactor {

std::string node_list(const std::vector<const NodeInfo*>& types) {
  std::string out;
  std::size_t width = 0;
  for (const NodeInfo* info : types) width = std::max(width, info->type.size());
  for (const NodeInfo* info : types) out += fmt::format("{:<{}}  {}\n", info->type, width, info->summary);
  return out;
}

std::string metric_help(const MetricInfo& metric) {
  const std::string better =
      metric.better == Better::neither ? "" : fmt::format("; {} is better", name_of(metric.better));
  return fmt::format("  {} ({}{})\n      {}\n", metric.name, metric.unit == "1" ? "number" : metric.unit, better,
                     metric_text(metric));
}

std::string node_help(const NodeInfo& info) {
  std::string out = fmt::format("{}: {}\n", info.type, info.summary);
  if (!info.details.empty()) out += "\n" + info.details + "\n";
  out += "\n" + lane_text(info) + warm_text(info) + "\n";
  if (!info.inputs.empty()) out += "\ninputs\n";
  for (const InputInfo& input : info.inputs) {
    out += fmt::format("  {} ({}; {})\n      {}\n", input.name, input.type->name, trigger_text(input), input.doc);
  }
  if (!info.outputs.empty()) out += "\noutputs\n";
  for (const OutputInfo& output : info.outputs) {
    out += fmt::format("  {} ({})\n      {}\n", output.name, output.type->name, output.doc);
  }
  if (!info.params.empty()) out += "\nparameters\n";
  for (const ParamInfo& param : info.params) {
    const std::string bounds = bounds_text(param);
    out += fmt::format("  {} ({}; {}{}{})\n      {}\n", param.name, kind_text(param),
                       param.default_value ? "default " : "", value_text(info, param),
                       bounds.empty() ? "" : "; " + bounds, param_text(param));
  }
  if (!info.metrics.empty()) out += "\nmetrics\n";
  for (const MetricInfo& metric : info.metrics) out += metric_help(metric);
  return out;
}

}  // namespace tactor
