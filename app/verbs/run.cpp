// `tactor run`: one graph, once.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/confirmation.hpp"
#include "app/interruption.hpp"
#include "app/results_folder.hpp"
#include "app/run/cost_traces.hpp"
#include "app/run/run.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/page_options.hpp"
#include "app/verbs/run_into_folder.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "app/view/run_view.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

struct RunArguments {
  fs::path graph;
  GraphOptions options;
  ResultsRequest results;
  RunTelling telling;
  bool follow = false;                // let a reference follow the run
  std::optional<fs::path> reference;  // a recording that judges the run
  std::optional<fs::path> costs;      // where to write what the steps took
  bool view = false;                  // show it in the browser
  bool no_dead_man = false;           // hardware gives a force though no button stops it
  PageOptions page;
};

/// Of a run until stopped nothing is kept that grows with it.
void refuse_to_keep_all(const RunArguments& arguments, const Plan& plan) {
  if (plan.graph.duration != until_stopped) return;
  const char* option = arguments.costs ? "--record-costs" : arguments.follow ? "--follow" : nullptr;
  if (option == nullptr) return;
  throw InputError(plan.graph.place_of("duration").text() + ": duration: expected a time (s) with " + option +
                   ", which keeps something of the whole run, found " + std::string(until_stopped_text));
}

int run_graph(const RunArguments& arguments) {
  Registry registry(default_node_folders());
  const Plan plan = make_plan(load(arguments.graph, registry, arguments.options));
  refuse_to_keep_all(arguments, plan);
  const ResultsFolder results(fs::path("out") / plan.graph.name, arguments.results);
  results.refuse_to_replace(plan.graph.file);
  std::optional<CostTraces> costs;
  if (arguments.costs) costs.emplace(*arguments.costs, plan);
  RunOptions run_options;
  run_options.keeps_step_times = costs.has_value();
  run_options.without_dead_man = ask_without_dead_man(arguments.no_dead_man);
  run_options.reference_recording = arguments.reference;
  if (arguments.follow) {
    if (plan.graph.clock != Clock::real) {
      throw InputError(
          "--follow: expected a graph with clock: real, found clock: virtual, which is compared afterwards");
    }
    run_options.follow = &registry;
  }
  std::unique_ptr<RunView> shown;
  if (arguments.view) {
    shown = std::make_unique<RunView>(
        plan, arguments.page.ports,
        [&arguments](const std::string& url, const std::string& foxglove) {
          show_page(arguments.page, url, foxglove, arguments.telling.out());
        },
        is_interrupted);
    run_options.watcher = shown.get();
  }
  const RunResult result = run_into_folder(plan, results, run_options, arguments.telling);
  if (costs) costs->write(result);
  return exit_code_of(result);
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "run", "Run a graph; writes summary.json, report.html, graph.yaml, the recording, and live latencies.csv");
  const auto arguments = std::make_shared<RunArguments>();
  verb->add_option("graph", arguments->graph, "The graph file (YAML)")->type_name(value_type::graph)->required();
  arguments->options.add_to(*verb, true);
  add_results(*verb, arguments->results,
              "Folder for the results (default: out/NAME, or the first of out/NAME_2, out/NAME_3, ... that is free)");
  arguments->telling.add_to(*verb, "Print every metric, and the time that each node took; not for a blind experiment");
  verb->add_option("--record-costs", arguments->costs,
                   "A new folder for the times of all steps outside the real-time lane: one file NODE.csv per node, "
                   "which `cost: {trace: NODE.csv}` reads")
      ->type_name(value_type::folder);
  verb->add_flag("--follow", arguments->follow,
                 "With clock: real, let a reference follow the run, so that error and delay are known during the run");
  verb->add_option("--reference", arguments->reference,
                   "A recording to use instead of a reference run: its streams have the names of the outputs that feed "
                   "the metrics node, such as coupling.force")
      ->type_name(value_type::recording);
  add_no_dead_man(*verb, arguments->no_dead_man);
  CLI::Option* view =
      verb->add_flag("--view", arguments->view,
                     "Show the run in the browser as it happens; under the virtual clock it then runs in real time");
  arguments->page.add_to(*verb, view);
  verb->callback([arguments, &exit_code] { exit_code = run_graph(*arguments); });
}

}  // namespace tactor
