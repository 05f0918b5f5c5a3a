// `tactor schema`: graph files for editors, and message types for other programs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/verbs/graph_options.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/message_json.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

/// One line a type.
std::string message_list(const Registry& registry) {
  std::string text;
  for (const auto& [name, type] : registry.message_types()) {
    text += (text.empty() ? "[\n" : ",\n") + to_documented_json(*type);
  }
  return text + "\n]";
}

}  // namespace

void add_schema(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("schema", "Print the JSON Schema of graph files, for editors");
  const auto messages = std::make_shared<bool>(false);
  verb->add_flag("--messages", *messages, "Describe all message types instead: fields with units, frames and meaning");
  verb->callback([messages, &exit_code] {
    Registry registry(default_node_folders());
    load_all_libraries(registry);
    fmt::print("{}\n", *messages ? message_list(registry) : graph_schema(registry));
    exit_code = 0;
  });
}

}  // namespace tactor
