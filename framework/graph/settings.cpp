#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "framework/core/messages.hpp"
#include "framework/graph/plan_steps.hpp"
#include "framework/graph/texts.hpp"

namespace tactor {

namespace {

/// Why the setting cannot be made while the graph runs; empty where it can. `where` names the place in errors of the
/// value.
std::string why_not_settable(const GraphSpec& graph, const Kept& kept, const Setting& setting,
                             const std::string& where) {
  if (setting.value.empty()) return "expected node.parameter=value, found no value";
  std::vector<std::string> tunable;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const NodeSpec& node = graph.nodes[n];
    for (std::size_t p = 0; p < node.info->params.size(); ++p) {
      const ParamInfo& param = node.info->params[p];
      const std::string name = node.name + "." + param.name;
      if (param.tunable && kept.nodes[n]) tunable.push_back(name);
      if (name != setting.parameter) continue;
      if (!kept.nodes[n]) return "node " + node.name + " is left out: " + kept.node_reasons.at(n);
      if (!param.tunable) return node.info->type + " reads it only at the start; it cannot be set during the run";
      static_cast<void>(parse_parameter(node, p, setting.value, where));
      return {};
    }
  }
  return "the graph has no such parameter" + did_you_mean(setting.parameter, tunable);
}

/// The value of the node's parameter with that meaning, s; none where it has no such.
std::optional<double> time_of(const NodeSpec& node, ParamMeaning meaning) {
  const auto param = node.info->param(meaning);
  return param ? std::optional(std::get<double>(node.params[*param])) : std::nullopt;
}

/// A node that reaches what is set along a ramp has to be there before the setter goes on.
void check_ramps(const GraphSpec& graph, const NodeSpec& setter, Diagnostics& diagnostics) {
  const std::optional<double> change = time_of(setter, ParamMeaning::settling_time);
  if (!change) return;
  const auto path_of = [](const NodeSpec& node, ParamMeaning meaning) {
    return "nodes." + node.name + "." + node.info->params[*node.info->param(meaning)].name;
  };
  std::set<std::string> told;
  for (const Setting& setting : setter.info->sets(setter.params)) {
    const std::string name = setting.parameter.substr(0, setting.parameter.find('.'));
    const NodeSpec* node = graph.node(name);
    const std::optional<double> ramp = node != nullptr ? time_of(*node, ParamMeaning::ramp) : std::nullopt;
    if (!ramp || *ramp <= *change || !told.insert(name).second) continue;
    const std::string path = path_of(setter, ParamMeaning::settling_time);
    const std::string other = path_of(*node, ParamMeaning::ramp);
    diagnostics.error(graph.place_of(path),
                      path + ": expected at least " + duration_text(Duration::from_seconds(*ramp)) + ", the ramp of " +
                          name + " (" + other + ", " + graph.place_of(other).text() +
                          "), which would not be over; found " + duration_text(Duration::from_seconds(*change)));
  }
}

/// Whoever lets go of the dead-man button must not answer by that.
void check_buttons(const GraphSpec& graph, const NodeSpec& setter, Diagnostics& diagnostics) {
  for (const EdgeSpec& edge : graph.edges) {
    const NodeSpec* device = edge.to_node == setter.name ? graph.node(edge.from_node) : nullptr;
    const InputInfo* input = device != nullptr ? setter.info->input(edge.to_port) : nullptr;
    if (input == nullptr || !same_type(*input->type, message_type<DeviceState>())) continue;
    const auto dead_man = device->info->param(ParamMeaning::dead_man_button);
    if (!dead_man) continue;
    const auto* given = std::get_if<std::int64_t>(&device->params[*dead_man]);
    const std::int64_t button = given != nullptr ? *given : 1;
    for (std::size_t p = 0; p < setter.params.size(); ++p) {
      const ParamInfo& param = setter.info->params[p];
      if (button == 0 || param.meaning != ParamMeaning::answer_button) continue;
      if (std::get<std::int64_t>(setter.params[p]) != button) continue;
      const std::string path = "nodes." + setter.name + "." + param.name;
      const std::string other = "nodes." + device->name + "." + device->info->params[*dead_man].name;
      diagnostics.error(graph.place_of(path), path + ": expected another button than the dead-man button of " +
                                                  device->info->type + " (" + other + ", " +
                                                  graph.place_of(other).text() +
                                                  "), because taking hold of the device would answer; found " +
                                                  std::to_string(button) + " for both");
    }
  }
}

}  // namespace

void check_settings(const GraphSpec& graph, const Kept& kept, const NodeSpec& setter, Diagnostics& diagnostics) {
  check_ramps(graph, setter, diagnostics);
  check_buttons(graph, setter, diagnostics);
  for (const Setting& setting : setter.info->sets(setter.params)) {
    const std::string path = "nodes." + setter.name + "." + setting.path;
    const SourceLocation place = graph.place_of(path);
    try {
      const std::string why = why_not_settable(graph, kept, setting, path);
      if (!why.empty()) diagnostics.error(place, path + ": " + setting.text() + ": " + why);
    } catch (const InputError& error) {
      diagnostics.error(place, error.what());
    }
  }
}

}  // namespace tactor
