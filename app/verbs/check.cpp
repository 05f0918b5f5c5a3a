// `tactor check`: whether graphs can be run.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "app/interruption.hpp"
#include "app/lean/physics_fit.hpp"
#include "app/output.hpp"
#include "app/run/run_metrics.hpp"
#include "app/terminal.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/node_help.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

struct CheckArguments {
  std::vector<std::filesystem::path> graphs;
  GraphOptions options;
  bool explained = false;
  bool with_metrics = false;
};

/// What a run of the plan reports, and why it leaves out what nodes declare besides.
std::string planned_metrics(const Plan& plan) {
  const RunMetrics metrics = run_metrics(plan, true);
  std::string text = "\nmetrics\n";
  for (const auto& [name, metric] : metrics.reported) text += metric_help(metric);
  if (!metrics.left_out.empty()) text += "\nleft out\n";
  for (const auto& [name, why] : metrics.left_out) text += fmt::format("  {}: {}\n", name, why);
  return wrapped(text, terminal_columns());
}

int check_graphs(const CheckArguments& arguments) {
  Registry registry(default_node_folders());
  bool bad = false;
  for (const std::filesystem::path& graph : arguments.graphs) {
    try {
      const Plan plan = make_plan(load(graph, registry, arguments.options));
      for (const std::string& note : check_nodes(plan)) tell_note(note);
      fmt::print("{}: ok\n", graph.string());
      if (arguments.explained) {
        fmt::print("{}\n", explain(plan, terminal_columns()));
        const std::optional<PhysicsFit> physics = measure_physics_fit(plan, is_interrupted);
        if (physics) fmt::print("{}\n", wrapped("physics\n" + text_of(*physics, "  "), terminal_columns()));
      }
      if (arguments.with_metrics) fmt::print("{}\n", planned_metrics(plan));
    } catch (const InputError& error) {
      tell(fmt::format("{}\n", error.what()), LogLevel::error);
      bad = true;
    }
  }
  return bad ? 2 : 0;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("check", "Check graphs without running them");
  const auto arguments = std::make_shared<CheckArguments>();
  verb->add_option("graphs", arguments->graphs, "Graph files")->type_name(value_type::graph)->required();
  verb->add_flag(
      "--explain", arguments->explained,
      "Show what runs, the queues, and what was left out and why; a short run measures whether physics fits in a tick");
  verb->add_flag("--metrics", arguments->with_metrics, "Show the metrics that a run reports");
  arguments->options.add_to(*verb, false);
  verb->callback([arguments, &exit_code] { exit_code = check_graphs(*arguments); });
}

}  // namespace tactor
