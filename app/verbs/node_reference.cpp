#include "app/verbs/node_reference.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/run/run_metrics.hpp"
#include "framework/graph/texts.hpp"

namespace tactor {

namespace {

/// A default as a graph would say it.
std::string default_text(const ParamValue& value) {
  struct Visitor {
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return fmt::format("{}", v); }
    std::string operator()(double v) const { return fmt::format("{}", v); }
    std::string operator()(const std::string& v) const { return v.empty() ? "none" : v; }
    std::string operator()(const std::vector<double>& v) const {
      std::string out = "[";
      for (const double d : v) out += fmt::format("{}{}", out.size() > 1 ? ", " : "", d);
      return out + "]";
    }
    std::string operator()(const Table&) const { return "none"; }
    std::string operator()(const Mapping&) const { return "none"; }
  };
  return std::visit(Visitor{}, value);
}

/// The default of a parameter, or that it has none.
std::string value_text(const NodeInfo& info, const ParamInfo& param) {
  if (!param.default_value) return "required";
  if (info.haptic_rate && param.name == info.params[*info.rate_parameter].name) return "the graph's";
  const std::string value = default_text(*param.default_value);
  return param.as_in ? fmt::format("as in {} ({} otherwise)", name_of(*param.as_in), value) : value;
}

std::string kind_text(const ParamInfo& param) {
  switch (param.kind) {
    case ParamKind::boolean:
      return "true or false";
    case ParamKind::integer:
      return "integer";
    case ParamKind::real:
      return param.unit == "1" ? "number" : param.unit;
    case ParamKind::text:
      return "text";
    case ParamKind::choice: {
      std::string out;
      for (const std::string& c : param.choices) out += (out.empty() ? "" : " | ") + c;
      return out;
    }
    case ParamKind::file:
      return "file";
    case ParamKind::reals:
      return fmt::format("list of {}", param.unit == "1" ? "numbers" : param.unit);
    case ParamKind::table: {
      std::string out = "rows of {";
      for (const ColumnInfo& c : param.columns) {
        out += fmt::format("{}{} [{}]", out.back() == '{' ? "" : ", ", c.name, c.unit);
      }
      return out + "}";
    }
    case ParamKind::mapping:
      return "map of texts";
  }
  return {};
}

std::string bounds_text(const ParamInfo& param) {
  const bool low = std::isfinite(param.min);
  // The widest bound of an integer is no bound worth telling.
  const bool high = std::isfinite(param.max) && !(param.kind == ParamKind::integer && param.max >= 2147483648.0);
  if (!low && !high) return "";
  const char* more = param.above_min ? ">" : ">=";
  if (low && high) return fmt::format("{} {}, <= {}", more, param.min, param.max);
  return low ? fmt::format("{} {}", more, param.min) : fmt::format("<= {}", param.max);
}

std::string param_text(const ParamInfo& param) {
  return param.tunable ? param.doc + "; tunable while it runs" : param.doc;
}

std::string trigger_text(const InputInfo& input) {
  std::string out = input.required ? "required" : "optional";
  if (input.trigger == Trigger::yes) out += ", makes the node step";
  if (input.trigger == Trigger::when_alone) out += ", makes the node step if nothing else does";
  out += ", " + queue_text(input.queue);
  return out;
}

/// A text as a cell of a table in Markdown.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
  return text;
}

/// What a metric is, and the runs that do not report it.
std::string metric_text(const MetricInfo& metric) {
  std::string text = metric.doc;
  if (metric.summed) text += "; the sum over all nodes that report it";
  if (!metric.missing.empty()) text += "; missing where " + metric.missing;
  return text;
}

std::string metrics_markdown(const std::vector<MetricInfo>& metrics) {
  std::string out = "\n| metric | unit | better | |\n|---|---|---|---|\n";
  for (const MetricInfo& metric : metrics) {
    out += fmt::format("| `{}` | {} | {} | {} |\n", metric.name, metric.unit == "1" ? "" : metric.unit,
                       metric.better == Better::neither ? "" : name_of(metric.better), cell(metric_text(metric)));
  }
  return out;
}

/// The metrics that no node reports.
std::string program_metrics_markdown() {
  std::string out = "\n## Metrics that the program adds\n\nTo every run:\n" + metrics_markdown(program_metrics());
  out += "\nTo a run whose clock is real:\n" + metrics_markdown(live_metrics());
  out += "\nTo such a run with `--follow`:\n" + metrics_markdown(follower_metrics());
  out += "\nTo such a run, of each node in the real-time lane:\n" + metrics_markdown(lane_metrics());
  std::vector<MetricInfo> run_times = run_time_metrics();
  run_times.push_back(step_time_metric("NODE"));
  return out + "\nTo the tables of a study or a comparison:\n" + metrics_markdown(run_times);
}

/// Where it steps when the clock is real, unless the graph says otherwise.
std::string lane_text(const NodeInfo& info) {
  switch (info.lane) {
    case Lane::pool:
      return info.realtime_safe && info.rate_parameter ? "Lane: pool; realtime is allowed." : "Lane: pool.";
    case Lane::thread:
      return info.thread.empty() ? "Lane: thread." : "Lane: thread (" + info.thread + ").";
    case Lane::realtime:
      return "Lane: realtime.";
  }
  return {};
}

/// What it waits for before runs with it are judged; empty for nothing.
std::string warm_text(const NodeInfo& info) {
  return info.warm_when.empty() ? "" : " Warm when: " + info.warm_when + ".";
}

}  // namespace

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

std::string node_reference_markdown(const std::vector<const NodeInfo*>& types) {
  std::string out =
      "# Node types\n\nGenerated by `tactor nodes --markdown` from the declarations of the nodes; do not edit.\n";
  for (const NodeInfo* info : types) {
    out += fmt::format("\n## {}\n\n{}\n", info->type, info->summary);
    if (!info->details.empty()) out += "\n" + info->details + "\n";
    out += "\n" + lane_text(*info) + warm_text(*info) + "\n";
    if (!info->inputs.empty()) out += "\n| input | message | | |\n|---|---|---|---|\n";
    for (const InputInfo& input : info->inputs) {
      out +=
          fmt::format("| `{}` | {} | {} | {} |\n", input.name, input.type->name, trigger_text(input), cell(input.doc));
    }
    if (!info->outputs.empty()) out += "\n| output | message | |\n|---|---|---|\n";
    for (const OutputInfo& output : info->outputs) {
      out += fmt::format("| `{}` | {} | {} |\n", output.name, output.type->name, cell(output.doc));
    }
    if (!info->params.empty()) out += "\n| parameter | | default | bounds | |\n|---|---|---|---|---|\n";
    for (const ParamInfo& param : info->params) {
      out += fmt::format("| `{}` | {} | {} | {} | {} |\n", param.name, cell(kind_text(param)), value_text(*info, param),
                         bounds_text(param), cell(param_text(param)));
    }
    if (!info->metrics.empty()) out += metrics_markdown(info->metrics);
  }
  return out + program_metrics_markdown();
}

}  // namespace tactor
