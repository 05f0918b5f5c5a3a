#include "app/verbs/reference/example.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "framework/core/message.hpp"

namespace tactor {

namespace {

/// What a node is called in an example: the library of its type.
std::string name_of_node(const NodeInfo& info) {
  return info.type.substr(0, info.type.find('.'));
}

/// A number that the bounds allow.
double example_number(const ParamInfo& param) {
  if (std::isfinite(param.min) && std::isfinite(param.max)) return (param.min + param.max) / 2;
  if (std::isfinite(param.min)) return param.min + 1;
  return std::isfinite(param.max) ? std::min(0.0, param.max) : 1;
}

std::string with_unit(double value, const std::string& unit) {
  return unit == "1" ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

std::string example_value(const ParamInfo& param) {
  switch (param.kind) {
    case ParamKind::boolean:
      return "true";
    case ParamKind::integer:
      return fmt::format("{}", static_cast<std::int64_t>(std::max(param.min, 1.0)));
    case ParamKind::real:
      return with_unit(example_number(param), param.unit);
    case ParamKind::text:
      return "NAME";
    case ParamKind::choice:
      return param.choices.at(0);
    case ParamKind::file:
      return "FILE";
    case ParamKind::reals: {
      std::string list;
      for (std::size_t i = 0; i < std::max<std::size_t>(param.size, 1); ++i) {
        list += (i == 0 ? "" : ", ") + with_unit(example_number(param), param.unit);
      }
      return "[" + list + "]";
    }
    case ParamKind::table: {
      std::string row;
      for (const ColumnInfo& column : param.columns) {
        if (!column.default_value) row += (row.empty() ? "" : ", ") + column.name + ": " + with_unit(0, column.unit);
      }
      return "[{" + row + "}]";
    }
    case ParamKind::mapping:
      return "{NAME: TEXT}";
  }
  return {};
}

/// How well an output suits an input of the same type, by what both are called.
int likeness(const NodeInfo& from, const OutputInfo& output, const InputInfo& input) {
  if (name_of_node(from) == input.name) return 3;
  if (output.name == input.name) return 2;
  return name_of(from.role) == input.name ? 1 : 0;
}

/// `device.state`: an output that may feed the input; none where no node type sends such messages.
std::optional<std::string> feeding(const NodeInfo& reader, const InputInfo& input,
                                   const std::vector<const NodeInfo*>& types) {
  std::optional<std::string> found;
  int best = -1;
  for (const NodeInfo* info : types) {
    if (info == &reader) continue;
    // Two nodes of one library cannot both have its name.
    const bool is_neighbour = name_of_node(*info) == name_of_node(reader);
    const std::string sender = is_neighbour ? info->type.substr(info->type.find('.') + 1) : name_of_node(*info);
    for (const OutputInfo& output : info->outputs) {
      const bool is_refused = !input.refused_kind.empty() && output.kind == input.refused_kind;
      if (output.type == nullptr || !same_type(*output.type, *input.type) || is_refused) continue;
      const int like = is_neighbour ? 0 : likeness(*info, output, input);
      if (like <= best) continue;
      best = like;
      found = sender + "." + output.name;
    }
  }
  return found;
}

}  // namespace

std::string example_of(const NodeInfo& info, const std::vector<const NodeInfo*>& types) {
  const std::string name = name_of_node(info);
  std::string text = fmt::format("nodes:\n  {}:\n    type: {}\n", name, info.type);
  for (const ParamInfo& param : info.params) {
    if (!param.default_value) text += fmt::format("    {}: {}\n", param.name, example_value(param));
  }
  std::string edges;
  for (const InputInfo& input : info.inputs) {
    if (!input.required) continue;
    if (const auto from = feeding(info, input, types))
      edges += fmt::format("  - {} -> {}.{}\n", *from, name, input.name);
  }
  return edges.empty() ? text : text + "edges:\n" + edges;
}

}  // namespace tactor
