// `tactor nodes`: the node types there are.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "app/verbs/graph_options.hpp"
#include "app/verbs/node_help.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/node/registry.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace {

int list_nodes(const std::string& type) {
  Registry registry(default_node_folders());
  if (const std::size_t colon = type.rfind(':'); colon != std::string::npos && colon > 0) {
    const std::filesystem::path file = named_file(type.substr(0, colon), {.noun = "a Python file"});
    fmt::print("{}", node_help(registry.find_python(std::filesystem::absolute(file), type.substr(colon + 1))));
    return 0;
  }
  if (!type.empty()) {
    if (const NodeInfo* info = registry.find(type)) {
      fmt::print("{}", node_help(*info));
      return 0;
    }
  }
  load_all_libraries(registry);
  if (!type.empty()) {
    std::vector<std::string> names;
    for (const NodeInfo* info : registry.types()) names.push_back(info->type);
    std::string message = "there is no node type " + type + did_you_mean(type, names) + "; `tactor nodes` lists them";
    const std::string prefix = type.substr(0, type.find('.'));
    const auto of_prefix = [&](const std::string& name) { return name.starts_with(prefix + "."); };
    if (prefix != type && std::none_of(names.begin(), names.end(), of_prefix)) {
      message += "; " + registry.why_missing(prefix);
    }
    throw InputError(message);
  }
  fmt::print("{}", node_list(registry.types()));
  return 0;
}

}  // namespace

void add_nodes(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("nodes", "List the node types, or describe one in full");
  const auto type = std::make_shared<std::string>();
  verb->add_option("type", *type, "A node type, for example prediction.ar, or FILE.py:Class")
      ->type_name(value_type::node_type);
  verb->callback([type, &exit_code] { exit_code = list_nodes(*type); });
}

}  // namespace tactor
