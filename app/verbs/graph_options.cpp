#include "app/verbs/graph_options.hpp"

#include <algorithm>
#include <thread>

#include "app/verbs/option_values.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

void GraphOptions::add_to(CLI::App& verb, bool with_seed) {
  verb.add_option("--over", over, "Lay a file over the graph, for example one of graphs/methods; comes before --set")
      ->expected(1, 16)
      ->allow_extra_args(false);
  verb.add_option("--set", set, "Replace a value: node.parameter=value, with or without unit")
      ->expected(1, 1000)
      ->allow_extra_args(false);
  if (with_seed) add_seed(verb, "--seed", seed, "Seed of everything random (default: the graph's)");
  add_duration(verb, "--duration", duration, "Time of the graph's clock to run, as `3 s` (default: the graph's)");
}

GraphSpec load(const std::filesystem::path& graph, Registry& registry, const GraphOptions& options) {
  return load_graph(named_file(graph, graph_files), registry, options.overrides());
}

void add_results(CLI::App& verb, ResultsRequest& results, const std::string& doc) {
  verb.add_option("--out", results.out, doc);
  verb.add_flag("--overwrite", results.overwrite, "Replace the results that are there");
}

unsigned cores() {
  return std::max(1U, std::thread::hardware_concurrency());
}

}  // namespace tactor
