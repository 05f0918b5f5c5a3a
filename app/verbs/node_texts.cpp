#include "app/verbs/node_texts.hpp"

#include <fmt/format.h>

#include <cmath>
#include <variant>
#include <vector>

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
    std::string operator()(std::monostate) const { return {}; }
  };
  return std::visit(Visitor{}, value);
}

}  // namespace

std::string value_text(const NodeInfo& info, const ParamInfo& param) {
  if (!param.default_value) return "required";
  if (info.haptic_rate && param.name == info.params[*info.rate_parameter].name) return "the graph's";
  if (std::holds_alternative<std::monostate>(*param.default_value)) return param.chosen;
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

std::string metric_text(const MetricInfo& metric) {
  std::string text = metric.doc;
  if (metric.summed) text += "; the sum over all nodes that report it";
  if (!metric.missing.empty()) text += "; missing where " + metric.missing;
  return text;
}

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

std::string warm_text(const NodeInfo& info) {
  return info.warm_when.empty() ? "" : " Warm when: " + info.warm_when + ".";
}

}  // namespace tactor
