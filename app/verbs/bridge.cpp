// `tactor bridge`: a program in another process is the physics of a run.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "app/bridge/bridge_run.hpp"
#include "app/bridge/bridge_server.hpp"
#include "app/confirmation.hpp"
#include "app/output.hpp"
#include "app/results_folder.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/run_into_folder.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

struct BridgeArguments {
  fs::path graph;
  GraphOptions options;
  BridgeAddress address;
  ResultsRequest results;
  RunTelling telling;
  bool no_dead_man = false;  // hardware gives a force though no button stops it
};

int run_bridge(const BridgeArguments& arguments) {
  Registry registry(default_node_folders());
  const Plan plan = make_plan(load(arguments.graph, registry, arguments.options));
  const ResultsFolder results(fs::path("out") / plan.graph.name, arguments.results);
  results.refuse_to_replace(plan.graph.file);
  BridgeServer server(arguments.address, tell_note);
  BridgeFigures figures;
  RunOptions options;
  // No reference knows the client's physics.
  options.without_reference = true;
  options.without_dead_man = ask_without_dead_man(arguments.no_dead_man);
  options.driver = [&](Session& session) {
    const auto run = std::make_shared<BridgeRun>(server, session, figures);
    fmt::print(arguments.telling.out(), "  {}\n  Ctrl-C ends it\n", server.url());
    std::fflush(arguments.telling.out());
    return [run] { run->attend(); };
  };
  const RunResult result = run_into_folder(plan, results, options, arguments.telling);
  server.close("the run is over");
  write_file(results.path() / "bridge.json", bridge_json(figures));
  fmt::print(arguments.telling.out(), "{}\n", bridge_text(figures));
  return exit_code_of(result);
}

}  // namespace

void add_bridge(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "bridge", "Run a graph whose physics is a program in another process, over a WebSocket; writes what run writes");
  const auto arguments = std::make_shared<BridgeArguments>();
  verb->add_option("graph", arguments->graph, "The graph file (YAML), with a node physics.external")
      ->type_name(value_type::graph)
      ->required();
  arguments->options.add_to(*verb, true);
  verb->add_option("--port", arguments->address.port, "Port to listen on (default: any free port)")
      ->type_name(value_type::port);
  verb->add_option("--listen", arguments->address.listen,
                   "Address of this machine to listen on; 0.0.0.0: all of them. Nothing is encrypted")
      ->type_name(value_type::address)
      ->capture_default_str();
  verb->add_option("--token", arguments->address.token,
                   "The token that a client needs: 16 to 128 letters, digits, - and _ (default: a random one)")
      ->type_name(value_type::name);
  add_results(*verb, arguments->results,
              "Folder for the results (default: out/NAME, or the first of out/NAME_2, out/NAME_3, ... that is free)");
  arguments->telling.add_to(*verb, "Print every metric, and the time that each node took");
  add_no_dead_man(*verb, arguments->no_dead_man);
  verb->callback([arguments, &exit_code] { exit_code = run_bridge(*arguments); });
}

}  // namespace tactor
