// What `tactor run` and `tactor bridge` share: a run that is shown on the terminal and leaves a folder of results.
#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "app/results_folder.hpp"
#include "app/run/run.hpp"
#include "framework/graph/plan.hpp"

namespace CLI {
class App;
}

namespace tactor {

/// What is told of a run beside its folder.
struct RunTelling {
  bool all = false;                               ///< print every metric
  std::optional<std::filesystem::path> log_json;  ///< see EventLog
  /// Where the rest of what the command says goes: standard error if the log has standard output.
  [[nodiscard]] std::FILE* out() const { return log_json == "-" ? stderr : stdout; }
  /// Adds --all and --log-json.
  void add_to(CLI::App& verb, const std::string& about_all);
};

/// Runs the plan and writes summary.json, report.html, graph.yaml, the recording, live latencies.csv, and the file of
/// the flight recorder where it is to stay. If the log goes to standard output, it stands alone there. Of the options
/// it sets those that concern the folder, the terminal and signals. Where a step never came back, the process ends
/// here, with exit code 1.
RunResult run_into_folder(const Plan& plan, const ResultsFolder& results, RunOptions options,
                          const RunTelling& telling);

/// The exit code of a command that ran it.
int exit_code_of(const RunResult& result);

}  // namespace tactor
