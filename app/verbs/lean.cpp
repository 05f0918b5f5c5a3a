// `tactor lean`: what an error budget allows to leave out.
#include "app/interruption.hpp"
#include "app/lean/lean_command.hpp"
#include "app/run/timing.hpp"
#include "app/study/spec/study_spec.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace {
struct LeanArguments {
  LeanRequest lean;
  GraphOptions options;
};
}  // namespace

void add_lean(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "lean",
      "Leave out and coarsen what an error budget allows; writes the cheapest graph found and what each step saved");
  const auto arguments = std::make_shared<LeanArguments>();
  LeanRequest& lean = arguments->lean;
  verb->add_option("graph", lean.graph, "The graph file")->type_name(value_type::graph)->required();
  add_number(*verb, "--budget", lean.budget, {.unit = "N", .min = 0, .above_min = true},
             "Largest allowed RMS error of the force against the graph's reference run, in N")
      ->required();
  add_number(*verb, "--torque-budget", lean.torque_budget, {.unit = "N m", .min = 0},
             "Largest allowed RMS error of the torque, in N m (default: the force budget at a lever of 50 mm)");
  choose_from(verb->add_option("--metric", lean.metric,
                               "The force that is judged: delivered, as displayed; or physics, "
                               "without delay")
                  ->capture_default_str(),
              {"delivered", "physics"});
  add_integer(*verb, "--seeds", lean.seeds, 1, 100,
              "Number of seeds, starting with the graph's; the same number of other seeds checks the result")
      ->default_str("1");
  add_integer(*verb, "--repeats", lean.repeats, 1, most_repeats,
              "Repeats of each seed; the median counts. With several, one more run before them does not count")
      ->default_str("3");
  add_results(*verb, lean.results,
              "The graph to write; the table goes beside it as .md and .json (default: out/NAME_lean.yaml, or the "
              "first of out/NAME_lean_2.yaml, ... that is free)",
              value_type::file);
  arguments->options.add_to(*verb, true);
  verb->callback([arguments, &exit_code] {
    arguments->lean.overrides = arguments->options.overrides;
    arguments->lean.graph = named_file(arguments->lean.graph, graph_files);
    arguments->lean.interrupted = is_interrupted;
    exit_code = run_lean(arguments->lean);
  });
}

}  // namespace tactor
