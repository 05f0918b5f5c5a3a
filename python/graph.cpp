#include "python/graph.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <string_view>

#include "framework/core/message_json.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/session/add_feed.hpp"
#include "framework/yaml/file_finder.hpp"
#include "python/file_text.hpp"
#include "python/release_lock.hpp"

namespace tactor::python {

namespace py = pybind11;

namespace {

Patch patch_of(const Change& change) {
  const auto& [how, text] = change;
  // Errors name the keyword.
  if (how == "set") return set_patch(text, how);
  if (how == "over") return over_patch(text, how);
  if (how == "seed" || how == "duration") return option_patch(how, how, text);
  TACTOR_DEMAND(how == "map");
  // JSON is YAML. Its places in the text mean nothing to who gave a mapping.
  const SourceLocation place{"over (a mapping)", 0, 0};
  Diagnostics diagnostics;
  std::optional<Tree> tree = parse_yaml(text, place.file, diagnostics);
  diagnostics.throw_if_any();
  if (!tree || !tree->is_map()) throw InputError("over: expected the keys of a graph file, found " + text);
  set_places(*tree, place);
  return {place, std::move(*tree)};
}

/// Outputs of the planned nodes, with the descriptions of their messages.
py::dict outputs_of(const Graph& graph) {
  py::dict outputs;
  const Plan plan = graph.plan();
  for (const NodeSpec& node : plan.nodes) {
    for (const OutputInfo& output : node.info->outputs) {
      outputs[py::str(node.name + "." + output.name)] = to_documented_json(*output.type);
    }
  }
  return outputs;
}

py::list inputs_of(const Graph& graph) {
  py::list inputs;
  for (const NodeSpec& node : graph.spec().nodes) {
    for (const InputInfo& input : node.info->inputs) inputs.append(node.name + "." + input.name);
  }
  return inputs;
}

py::dict nodes_of(const Graph& graph) {
  py::dict nodes;
  for (const NodeSpec& node : graph.spec().nodes) nodes[py::str(node.name)] = node.info->type;
  return nodes;
}

py::object value_of(const ParamValue& value) {
  struct Visitor {
    py::object operator()(bool v) const { return py::bool_(v); }
    py::object operator()(std::int64_t v) const { return py::int_(v); }
    py::object operator()(double v) const { return py::float_(v); }
    py::object operator()(const std::string& v) const { return py::str(v); }
    py::object operator()(const std::vector<double>& v) const { return py::cast(v); }
    py::object operator()(const Table&) const { return py::none(); }
    py::object operator()(const Mapping&) const { return py::none(); }
    py::object operator()(std::monostate) const { return py::none(); }
  };
  return std::visit(Visitor{}, value);
}

const char* kind_name(ParamKind kind) {
  constexpr const char* names[]{"boolean", "integer", "real", "text", "choice", "file", "reals", "table", "mapping"};
  return names[static_cast<std::size_t>(kind)];
}

py::dict declaration_of(const NodeInfo& info) {
  using namespace py::literals;
  py::list inputs, outputs, params, metrics;
  for (const InputInfo& input : info.inputs) {
    inputs.append(py::dict("name"_a = input.name, "message"_a = input.type->name, "doc"_a = input.doc,
                           "required"_a = input.required));
  }
  for (const OutputInfo& output : info.outputs) {
    outputs.append(py::dict("name"_a = output.name, "message"_a = output.type->name, "doc"_a = output.doc));
  }
  for (const ParamInfo& param : info.params) {
    params.append(py::dict("name"_a = param.name, "kind"_a = kind_name(param.kind), "unit"_a = param.unit,
                           "default"_a = param.default_value ? value_of(*param.default_value) : py::none(),
                           "required"_a = !param.default_value, "min"_a = param.min, "max"_a = param.max,
                           "choices"_a = param.choices, "tunable"_a = param.tunable, "doc"_a = param.doc));
  }
  for (const MetricInfo& metric : info.metrics) {
    metrics.append(py::dict("name"_a = metric.name, "unit"_a = metric.unit, "better"_a = name_of(metric.better),
                            "doc"_a = metric.doc));
  }
  return py::dict("type"_a = info.type, "summary"_a = info.summary, "details"_a = info.details,
                  "role"_a = name_of(info.role), "inputs"_a = inputs, "outputs"_a = outputs, "params"_a = params,
                  "metrics"_a = metrics);
}

py::list declarations() {
  Registry registry(default_node_folders());
  registry.load_all();
  py::list all;
  for (const NodeInfo* info : registry.types()) all.append(declaration_of(*info));
  return all;
}

}  // namespace

Graph::Graph(const std::string& file, const std::vector<Change>& changes)
    : registry_(std::make_shared<Registry>(default_node_folders())) {
  Overrides overrides;
  for (const Change& change : changes) overrides.push_back(patch_of(change));
  spec_ = load_graph(named_file(file, graph_files), *registry_, overrides);
}

Graph Graph::with_feeds(const std::vector<std::string>& inputs) const {
  Graph fed(*this);
  for (const std::string& input : inputs) add_feed(fed.spec_, input, *fed.registry_);
  return fed;
}

std::vector<std::string> Graph::check() const {
  return check_nodes(plan());
}

Plan Graph::plan_for(const std::vector<std::string>& tapped) const {
  GraphSpec listened = spec_;
  for (const std::string& output : tapped) {
    const std::size_t dot = output.find('.');
    const NodeSpec* node = dot == std::string::npos ? nullptr : listened.node(output.substr(0, dot));
    const bool is_there = node != nullptr && node->info->output(output.substr(dot + 1)) != nullptr;
    const bool is_new = std::find(listened.record.begin(), listened.record.end(), output) == listened.record.end();
    if (is_there && is_new) listened.record.push_back(output);
  }
  Plan plan = make_plan(std::move(listened));
  const auto only_tapped = [this](const std::string& output) {
    return std::find(spec_.record.begin(), spec_.record.end(), output) == spec_.record.end();
  };
  plan.graph.record = spec_.record;
  std::erase_if(plan.streams, [&](const PlannedStream& stream) { return only_tapped(stream.name); });
  std::erase_if(plan.left_out, [&](const auto& part) {
    constexpr std::string_view recording = "recording ";
    return part.what.starts_with(recording) && only_tapped(part.what.substr(recording.size()));
  });
  return plan;
}

void bind_graph(py::module_& module) {
  py::class_<Graph>(module, "Graph")
      .def(py::init([](const std::string& file, const std::vector<Change>& changes) {
             return without_lock([&] { return Graph(file, changes); });
           }),
           py::arg("file"), py::arg("changes"))
      .def_property_readonly("name", [](const Graph& graph) { return python_text(graph.spec().name); })
      .def_property_readonly("title", [](const Graph& graph) { return graph.spec().title; })
      .def_property_readonly("file", [](const Graph& graph) { return python_text(graph.spec().file.native()); })
      .def_property_readonly("clock",
                             [](const Graph& graph) { return graph.spec().clock == Clock::real ? "real" : "virtual"; })
      .def_property_readonly("seed", [](const Graph& graph) { return graph.spec().seed; })
      .def_property_readonly("duration",
                             [](const Graph& graph) {
                               const Duration planned = graph.spec().duration;
                               return planned == until_stopped ? std::numeric_limits<double>::infinity()
                                                               : planned.seconds();
                             })
      .def_property_readonly("nodes", nodes_of)
      .def_property_readonly("inputs", inputs_of)
      .def_property_readonly("outputs", outputs_of)
      // With the lock, because it may add to the registry, which several graphs have.
      .def("with_feeds", &Graph::with_feeds, py::arg("inputs"))
      .def("check", [](const Graph& graph) { return python_texts(without_lock([&] { return graph.check(); })); })
      .def("to_yaml", [](const Graph& graph) { return python_text(to_yaml(graph.spec())); })
      .def(
          "explain",
          [](const Graph& graph, std::size_t columns) { return python_text(explain(graph.plan(), columns)); },
          py::arg("columns"))
      .def("diagram", [](const Graph& graph) { return python_text(to_diagram(graph.plan(), DiagramFormat::mermaid)); });
  module.def("declarations", declarations);
}

}  // namespace tactor::python
