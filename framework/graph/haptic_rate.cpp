// The rate of the haptic loop, which a graph and its nodes may give, and which is one for all of them.
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

// A rate as it was given.
struct GivenRate {
  double value = 0;
  std::string path;
  const Tree* tree = nullptr;
};

}  // namespace

void read_haptic_rate(GraphSpec& graph, const Tree& tree, Diagnostics& diagnostics) {
  std::optional<GivenRate> first;
  const auto take = [&](const GivenRate& rate) {
    if (!first) {
      first = rate;
    } else if (rate.value != first->value) {
      diagnostics.error(rate.tree->place, rate.path + ": expected " + describe(*first->tree) + " as in " + first->path +
                                              " (" + first->tree->place.text() + "), found " + describe(*rate.tree) +
                                              "; all nodes of the haptic loop step at one rate: give it once, as the "
                                              "graph's rate, and take it out of the nodes");
    }
  };
  if (const Tree* rate = tree.value("rate")) {
    const auto value = read_number(*rate, "rate", {.unit = "Hz", .min = lowest_rate, .max = highest_rate}, diagnostics);
    if (value) take({*value, "rate", rate});
  }
  for (const NodeSpec& node : graph.nodes) {
    if (!node.info->haptic_rate) continue;
    const std::size_t i = *node.info->rate_parameter;
    const Tree* rate = tree.value("nodes")->value(node.name)->value(node.info->params[i].name);
    // A value that could not be read has its own error.
    const auto* value = std::get_if<double>(&node.params[i]);
    if (rate != nullptr && value != nullptr) take({*value, "nodes." + node.name + ".rate", rate});
  }
  if (first) graph.rate = first->value;
  for (NodeSpec& node : graph.nodes) {
    if (node.info->haptic_rate) node.params[*node.info->rate_parameter] = graph.rate;
  }
}

}  // namespace tactor
