// `tactor replay`: a live run made again from its recording.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "app/results_folder.hpp"
#include "app/run/replay.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {
struct ReplayArguments {
  std::filesystem::path recording;
  ResultsRequest results;
};
}  // namespace

void add_replay(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("replay", "Repeat a recorded live run, byte for byte");
  const auto arguments = std::make_shared<ReplayArguments>();
  verb->add_option("recording", arguments->recording, "The recording of a live run (HDF5)")
      ->type_name(value_type::recording)
      ->required();
  add_results(*verb, arguments->results, "Folder for the new recording (default: out/replay)");
  verb->callback([arguments, &exit_code] {
    Registry registry(default_node_folders());
    const ResultsFolder results("out/replay", arguments->results);
    results.refuse_to_replace(arguments->recording);
    results.clear();
    replay_recording(arguments->recording, results.path(), registry);
    fmt::print("  {}\n", (results.path() / "recording.h5").string());
    exit_code = 0;
  });
}

}  // namespace tactor
