// `tactor compare`: several graphs side by side.
#include <fmt/format.h>

#include "app/results_folder.hpp"
#include "app/study/spec/study_spec.hpp"
#include "app/study/study_command.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/scene_methods.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {
struct CompareArguments {
  std::vector<fs::path> graphs;
  std::vector<std::string> methods;
  CompareRequest comparison;
  GraphOptions options;
  ResultsRequest results;
};
std::vector<ComparedGraph> compared(const CompareArguments& arguments) {
  if (!arguments.methods.empty()) {
    if (arguments.graphs.size() != 1) {
      throw InputError(fmt::format("--methods: expected one graph, found {}", arguments.graphs.size()));
    }
    return scene_with_methods(arguments.graphs.front(), arguments.methods);
  }
  std::vector<ComparedGraph> graphs;
  for (const fs::path& graph : arguments.graphs) graphs.push_back({.file = named_file(graph, graph_files)});
  return graphs;
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("compare", "Run several graphs over several seeds, side by side");
  const auto arguments = std::make_shared<CompareArguments>();
  CompareRequest& comparison = arguments->comparison;
  comparison.jobs = cores();
  verb->add_option("graphs", arguments->graphs, "Graph files; the others are compared with the first")
      ->type_name(value_type::graph)
      ->required();
  verb->add_option(
          "--methods", arguments->methods,
          "Compare methods on one scene instead, for example `bunny --methods off,fixed,local`: graphs of these "
          "names beside the scene, or files of graphs/methods that are laid over it")
      ->type_name(value_type::method)
      ->delimiter(',')
      ->allow_extra_args(false);
  arguments->options.add_to(*verb, false);
  add_integer(*verb, "--seeds", comparison.seeds, 1, most_seeds, "Number of seeds")->default_str("6");
  add_seed(*verb, "--first-seed", comparison.first_seed, "The first seed")->default_str("1");
  verb->add_flag("--brief", comparison.brief,
                 "Print error, delay, smoothness and run time alone; the files hold the rest");
  add_integer(*verb, "--repeats", comparison.repeats, 1, most_repeats,
              "Repeats of each seed; the median run time counts. With several, one more run before them does not count")
      ->default_str("1");
  add_integer(*verb, "--jobs", comparison.jobs, 1, most_jobs,
              "Number of reference runs at once (default: the number of cores)");
  add_results(
      *verb, arguments->results,
      "Folder for the results (default: out/compare, or the first of out/compare_2, out/compare_3, ... that is free)");
  choose_from(verb->add_option_function<std::string>(
                  "--judge",
                  [&comparison](const std::string& part) {
                    comparison.judge = part == "whole" ? JudgedPart::whole : JudgedPart::warm;
                  },
                  "Which part of the runs the metrics cover: warm, from when every compared run is warm, or whole "
                  "(default: warm)"),
              {"warm", "whole"});
  verb->callback([arguments, &exit_code] {
    CompareRequest& made = arguments->comparison;
    made.graphs = compared(*arguments);
    made.overrides = arguments->options.overrides;
    made.out = results_folder(fs::path("out") / "compare", arguments->results);
    exit_code = run_compare(made);
  });
}

}  // namespace tactor
