// What `tactor run` and `tactor bridge` share: a run that is shown on the terminal and leaves a folder of results.
#pragma once

#include "app/results_folder.hpp"
#include "app/run/run.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// Runs the plan and writes summary.json, report.html, graph.yaml, the recording, and live latencies.csv. `all`: print
/// every metric. Of the options it sets those that concern the folder, the terminal and signals. Where a step never
/// came back, the process ends here, with exit code 1.
RunResult run_into_folder(const Plan& plan, const ResultsFolder& results, RunOptions options, bool all);

/// The exit code of a command that ran it.
int exit_code_of(const RunResult& result);

}  // namespace tactor
