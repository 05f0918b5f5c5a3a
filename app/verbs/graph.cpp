// `tactor graph`: a graph as a diagram.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/command_output.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

struct GraphArguments {
  std::filesystem::path graph;
  GraphOptions options;
  std::string format = "mermaid";
};

std::string svg_of(const std::string& dot) {
  const CommandResult result = run_command({.words = {"dot", "-Tsvg"}, .input = dot});
  if (result.is_good()) return result.out;
  throw RunError(fmt::format("dot {} (Debian package graphviz)", failure_of(result)));
}

int draw_graph(const GraphArguments& arguments) {
  Registry registry(default_node_folders());
  const Plan plan = make_plan(load(arguments.graph, registry, arguments.options));
  if (arguments.format == "mermaid") fmt::print("{}", to_diagram(plan, DiagramFormat::mermaid));
  if (arguments.format == "dot") fmt::print("{}", to_diagram(plan, DiagramFormat::dot));
  if (arguments.format == "svg") fmt::print("{}", svg_of(to_diagram(plan, DiagramFormat::dot)));
  return 0;
}

}  // namespace

void add_graph(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("graph", "Draw a graph");
  const auto arguments = std::make_shared<GraphArguments>();
  verb->add_option("graph", arguments->graph, "The graph file")->type_name(value_type::graph)->required();
  choose_from(verb->add_option("--format", arguments->format, "mermaid, dot or svg")->capture_default_str(),
              {"mermaid", "dot", "svg"});
  arguments->options.add_to(*verb, false);
  verb->callback([arguments, &exit_code] { exit_code = draw_graph(*arguments); });
}

}  // namespace tactor
