// `tactor schema`: graph files for editors.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/verbs/verbs.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

void add_schema(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("schema", "Print the JSON Schema of graph files, for editors");
  verb->callback([&exit_code] {
    Registry registry(default_node_folders());
    fmt::print("{}\n", graph_schema(registry));
    exit_code = 0;
  });
}

}  // namespace tactor
