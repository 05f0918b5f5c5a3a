// A page a node type, and their index by what they do in the pipeline.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "app/verbs/named_graphs.hpp"
#include "app/verbs/node_texts.hpp"
#include "app/verbs/reference/example.hpp"
#include "app/verbs/reference/pages.hpp"
#include "framework/core/input_file.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

namespace {

/// The graphs that name a node type, by the type.
using Uses = std::map<std::string, std::vector<std::string>>;

constexpr std::size_t most_uses = 8;  // that a page names

/// In the order of the pipeline.
constexpr std::array<std::pair<Role, const char*>, role_count> stages{{{Role::source, "Sources of motion and force"},
                                                                       {Role::device, "Devices"},
                                                                       {Role::collision, "Collision"},
                                                                       {Role::dynamics, "Dynamics"},
                                                                       {Role::coupling, "Coupling"},
                                                                       {Role::prediction, "Prediction"},
                                                                       {Role::interpolation, "Interpolation"},
                                                                       {Role::force_field, "Force fields"},
                                                                       {Role::sink, "Sinks"},
                                                                       {Role::other, "Other nodes"}}};

/// The types that the shipped graphs name themselves, without what they extend.
Uses shipped_uses() {
  FileKind shipped = graph_files;
  shipped.variable.clear();
  Uses uses;
  for (const NamedGraph& graph : graphs_by_name(shipped)) {
    Diagnostics ignored;
    const std::optional<Tree> tree = parse_yaml(read_input_file(graph.file, max_yaml_bytes), graph.name, ignored);
    const Tree* nodes = tree ? tree->value("nodes") : nullptr;
    if (nodes == nullptr) continue;
    for (const TreeEntry& node : nodes->entries) {
      const Tree* type = node.value.value("type");
      if (type == nullptr) continue;
      std::vector<std::string>& named = uses[type->text];
      if (named.empty() || named.back() != graph.name) named.push_back(graph.name);
    }
  }
  return uses;
}

/// A message type, linked to its fields.
std::string message_link(const PageWriter& page, const MessageType* type) {
  if (type == &any_message()) return "by its parameters";
  return page.link(type->name, "message_types.md#" + anchor_of(type->name));
}

void add_ports(const NodeInfo& info, PageWriter& page) {
  std::vector<std::vector<std::string>> rows;
  for (const InputInfo& input : info.inputs) {
    rows.push_back(
        {code_span(input.name), message_link(page, input.type), page.text(trigger_text(input)), page.text(input.doc)});
  }
  if (!rows.empty()) page.heading(2, "Inputs");
  page.table({"input", "message", "when", "meaning"}, rows);
  rows.clear();
  for (const OutputInfo& output : info.outputs) {
    rows.push_back({code_span(output.name), message_link(page, output.type), page.text(output.doc)});
  }
  if (!rows.empty()) page.heading(2, "Outputs");
  page.table({"output", "message", "meaning"}, rows);
}

/// A default, as code where a graph could say it.
std::string default_cell(const NodeInfo& info, const ParamInfo& param, const PageWriter& page) {
  const std::string text = value_text(info, param);
  const bool is_prose = text == "required" || text == "none" || text.starts_with("as in ") || text.starts_with("the ");
  return is_prose ? page.text(text) : code_span(text);
}

void add_parameters(const NodeInfo& info, PageWriter& page) {
  std::vector<std::vector<std::string>> rows;
  for (const ParamInfo& param : info.params) {
    rows.push_back({code_span(param.name), page.text(kind_text(param)), default_cell(info, param, page),
                    page.text(bounds_text(param)), page.text(param_text(param))});
  }
  if (!rows.empty()) page.heading(2, "Parameters");
  page.table({"parameter", "unit or kind", "default", "bounds", "meaning"}, rows);
}

void add_uses(const std::vector<std::string>& graphs, PageWriter& page) {
  if (graphs.empty()) return;
  page.heading(2, "Used by");
  std::string text = "Shipped graphs that name it:";
  for (std::size_t i = 0; i < std::min(graphs.size(), most_uses); ++i) {
    text += (i == 0 ? " " : ", ") + page.link(graphs[i], "../../graphs/" + graphs[i] + ".yaml");
  }
  if (graphs.size() > most_uses) text += fmt::format(", and {} more", graphs.size() - most_uses);
  page.markdown(text + ".");
}

void add_node_page(const NodeInfo& info, const ReferenceSource& source, const Uses& uses, Pages& pages) {
  PageWriter page("nodes/" + info.type + ".md", info.type, source.types);
  page.prose(info.summary);
  page.code("yaml", example_of(info, source.registry.types()));
  page.prose(info.details);
  page.prose(lane_text(info) + warm_text(info));
  add_ports(info, page);
  add_parameters(info, page);
  if (!info.metrics.empty()) page.heading(2, "Metrics");
  add_metric_table(info.metrics, page);
  const auto used = uses.find(info.type);
  if (used != uses.end()) add_uses(used->second, page);
  page.put_into(pages);
}

}  // namespace

void add_node_pages(const ReferenceSource& source, Pages& pages) {
  const Uses uses = shipped_uses();
  PageWriter index("nodes.md", "Node types", source.types);
  index.prose(
      "Find a node type and what it does; its page has ports, parameters with units and defaults, and metrics. `tactor "
      "nodes TYPE` prints the same on the terminal.");
  for (const auto& [role, stage] : stages) {
    std::vector<std::vector<std::string>> rows;
    for (const NodeInfo* info : source.registry.types()) {
      if (info->role != role) continue;
      rows.push_back({index.link(info->type, "nodes/" + info->type + ".md"), index.text(info->summary)});
      add_node_page(*info, source, uses, pages);
    }
    if (!rows.empty()) index.heading(2, stage);
    index.table({"type", "what it does"}, rows);
  }
  index.put_into(pages);
}

}  // namespace tactor
