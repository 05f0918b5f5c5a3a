// `tactor explain`: what a scene needs, and what each node costs.
#include "app/lean/explain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/interruption.hpp"
#include "app/study/spec/study_spec.hpp"
#include "app/terminal.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

struct ExplainArguments {
  std::filesystem::path graph;
  GraphOptions options;
  std::int64_t repeats = 3;
  bool json = false;
};

int explain_costs(const ExplainArguments& arguments) {
  Registry registry(default_node_folders());
  const GraphSpec spec = load(arguments.graph, registry, arguments.options);
  if (spec.clock == Clock::real) {
    throw InputError(arguments.graph.string() +
                     ": expected clock: virtual, found clock: real; add --set clock=virtual, or see `tactor run`");
  }
  // A short run, unless the user says otherwise.
  const bool is_asked = find_assignment(arguments.options.overrides, "duration") != nullptr;
  const double seconds = is_asked ? spec.duration.seconds() : std::min(2.0, spec.duration.seconds());
  const Explanation found = explain_measured(spec, seconds, warmed_up(arguments.repeats), registry, is_interrupted);
  fmt::print("{}\n", arguments.json ? to_json(found).dump(2) : explanation_table(found, terminal_columns()));
  return 0;
}

}  // namespace

void add_explain(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "explain", "Show what a scene needs, what was left out, and the cost of each, measured by a short run");
  const auto arguments = std::make_shared<ExplainArguments>();
  verb->add_option("graph", arguments->graph, "The graph file")->type_name(value_type::graph)->required();
  verb->add_flag("--json", arguments->json, "Print JSON, for programs");
  add_integer(*verb, "--repeats", arguments->repeats, 1, most_repeats,
              "Number of runs; the median counts. With several, one more run before them does not count")
      ->default_str("3");
  arguments->options.add_to(*verb, true);
  verb->callback([arguments, &exit_code] { exit_code = explain_costs(*arguments); });
}

}  // namespace tactor
