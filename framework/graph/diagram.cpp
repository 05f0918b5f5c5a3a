#include "framework/graph/chains.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/texts.hpp"

namespace tactor {

namespace {

std::string edge_label(const PlannedEdge& edge, const std::string& line_break) {
  std::string text = edge.spec.from_port + " to " + edge.spec.to_port;
  if (edge.spec.from_port == edge.spec.to_port) text = edge.spec.from_port;
  text += line_break + queue_text(edge.spec.queue);
  if (edge.spec.delay.ns > 0) text += line_break + "delay " + duration_text(edge.spec.delay);
  return text;
}

// Mermaid takes some words (`end`, `class`) for its own, so nodes go by number.
std::string mermaid(const Plan& plan) {
  std::string text = "flowchart LR\n";
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const NodeSpec& node = plan.nodes[n];
    text += "  n" + std::to_string(n) + "[\"" + node.name + "<br/>" + node.info->type + "\"]\n";
  }
  for (const PlannedEdge& edge : plan.edges) {
    text += "  n" + std::to_string(edge.from) + (edge.triggers ? " -->" : " -.->") + "|\"" + edge_label(edge, "<br/>") +
            "\"| n" + std::to_string(edge.to) + "\n";
  }
  const auto loops = shared_loops(plan);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    text += "  subgraph loop" + std::to_string(i) + "[\"one loop\"]\n";
    for (const std::size_t n : loops[i]) text += "    n" + std::to_string(n) + "\n";
    text += "  end\n";
  }
  return text;
}

std::string dot(const Plan& plan) {
  std::string text = "digraph \"graph\" {\n  rankdir=LR;\n  node [shape=box];\n";
  for (const NodeSpec& node : plan.nodes) {
    text += "  \"" + node.name + "\" [label=\"" + node.name + "\\n" + node.info->type + "\"];\n";
  }
  for (const PlannedEdge& edge : plan.edges) {
    text += "  \"" + edge.spec.from_node + "\" -> \"" + edge.spec.to_node + "\" [label=\"" + edge_label(edge, "\\n") +
            "\"" + (edge.triggers ? "" : ", style=dashed") + "];\n";
  }
  const auto loops = shared_loops(plan);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    text += "  subgraph \"cluster_" + std::to_string(i) + "\" {\n    label=\"one loop\";\n";
    for (const std::size_t n : loops[i]) text += "    \"" + plan.nodes[n].name + "\";\n";
    text += "  }\n";
  }
  return text + "}\n";
}

}  // namespace

std::string to_diagram(const Plan& plan, DiagramFormat format) {
  return format == DiagramFormat::mermaid ? mermaid(plan) : dot(plan);
}

}  // namespace tactor
