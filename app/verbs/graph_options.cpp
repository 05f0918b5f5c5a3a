#include "app/verbs/graph_options.hpp"

#include <algorithm>
#include <thread>

#include "app/output.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "framework/node/registry.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

void GraphOptions::add_to(CLI::App& verb, bool with_seed) {
  // Each is taken where it stands, so that the list has the order of the command line.
  const auto add = [&](const std::string& name, const char* type, const std::string& doc,
                       const std::function<Patch(const std::string&)>& patch) {
    detail::add_text_option(verb, name, type, doc, [this, patch](const std::string& text) {
      overrides.push_back(patch(text));
    })->trigger_on_parse();
  };
  add("--over", value_type::method, "Lay a file over the graph, for example `kalman` of graphs/methods",
      [](const std::string& text) { return over_patch(text); });
  add("--set", "PATH=VALUE",
      "Replace a value, with or without unit: node.parameter=value; or a node: node={type: ...}. A later --over, --set "
      "or other option of this "
      "group overrides an earlier one",
      [](const std::string& text) { return set_patch(text); });
  if (with_seed) {
    add("--seed", "SEED", "Seed of all random numbers (default: the graph's)", [](const std::string& text) {
      return option_patch("--seed", "seed", std::to_string(option_seed("--seed", text)));
    });
  }
  add("--duration", "TIME",
      "How long to run, in time of the graph's clock, such as `3 s`, or with clock: real `until stopped` (default: the "
      "graph's)",
      [](const std::string& text) {
        if (text == until_stopped_text) return option_patch("--duration", "duration", text);
        return option_patch("--duration", "duration", number_text(option_duration("--duration", text)));
      });
}

GraphSpec load(const std::filesystem::path& graph, Registry& registry, const GraphOptions& options) {
  return load_graph(named_file(graph, graph_files), registry, options.overrides);
}

void load_all_libraries(Registry& registry) {
  registry.load_all();
  for (const std::string& why : registry.refused()) tell_note(why);
}

void add_results(CLI::App& verb, ResultsRequest& results, const std::string& doc, const char* type) {
  verb.add_option("--out", results.out, doc)->type_name(type);
  verb.add_flag("--overwrite", results.overwrite, "Replace existing results");
}

void add_no_dead_man(CLI::App& verb, bool& accepted) {
  verb.add_flag("--no-dead-man", accepted,
                "Let hardware give a force though no button stops it when you let go, without asking");
}

unsigned cores() {
  return std::max(1U, std::thread::hardware_concurrency());
}

}  // namespace tactor
