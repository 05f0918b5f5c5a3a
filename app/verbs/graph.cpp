// `tactor graph`: a graph as a diagram.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <array>
#include <cstdio>

#include "app/output.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

struct GraphArguments {
  std::filesystem::path graph;
  GraphOptions options;
  std::string format = "mermaid";
};

/// Standard output of `command FILE`, the file holding `input`.
std::string filter(const std::string& command, const std::string& input) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "input";
  write_file(file, input);
  FILE* pipe = popen((command + " '" + file.string() + "'").c_str(), "r");
  if (pipe == nullptr) throw RunError("cannot start " + command);
  std::string out;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) out.append(buffer.data(), n);
  if (pclose(pipe) != 0) throw RunError(command + " failed (Debian package graphviz)");
  return out;
}

int draw_graph(const GraphArguments& arguments) {
  Registry registry(default_node_folders());
  const Plan plan = make_plan(load(arguments.graph, registry, arguments.options));
  if (arguments.format == "mermaid") fmt::print("{}", to_diagram(plan, DiagramFormat::mermaid));
  if (arguments.format == "dot") fmt::print("{}", to_diagram(plan, DiagramFormat::dot));
  if (arguments.format == "svg") fmt::print("{}", filter("dot -Tsvg", to_diagram(plan, DiagramFormat::dot)));
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
