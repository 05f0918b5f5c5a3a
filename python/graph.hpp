// A graph as Python holds it, with the registry that its declarations live in.
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "framework/graph/plan.hpp"
#include "framework/graph/spec.hpp"
#include "framework/node/registry.hpp"

namespace tactor::python {

/// What is laid over a graph: how (`over`, `map`, `set`, `seed`, `duration`), and a text that says what.
using Change = std::pair<std::string, std::string>;

class Graph {
 public:
  /// Throws InputError and YamlError as the command does.
  Graph(const std::string& file, const std::vector<Change>& changes);

  [[nodiscard]] const GraphSpec& spec() const { return spec_; }
  [[nodiscard]] const std::shared_ptr<Registry>& registry() const { return registry_; }
  /// Throws YamlError where it cannot be planned.
  [[nodiscard]] Plan plan() const { return make_plan(spec_); }
  /// The same where somebody listens to these outputs: what makes them is not left out, and nothing more is recorded.
  [[nodiscard]] Plan plan_for(const std::vector<std::string>& tapped) const;
  /// The same graph with a node source.feed before each of these inputs (`device.target`).
  [[nodiscard]] Graph with_feeds(const std::vector<std::string>& inputs) const;
  /// Refuses what a run would refuse before it begins; returns what the nodes say of their input.
  [[nodiscard]] std::vector<std::string> check() const;

 private:
  std::shared_ptr<Registry> registry_;
  GraphSpec spec_;
};

/// Adds the class Graph, and the declarations of node types.
void bind_graph(pybind11::module_& module);

}  // namespace tactor::python
