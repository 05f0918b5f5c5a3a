// The HTML page of one run.
#pragma once

#include <string>

#include "app/run/run.hpp"

namespace tactor {

/// The report of one run: error and force over time, what a hand notices, the scene at the largest force, a zoom, the
/// rows of the paper's figures, and every metric. `graph`: whose scene is drawn; null: none.
std::string run_report(const RunResult& run, const GraphSpec* graph = nullptr);

/// What stood for others and what was left out, as an HTML list.
std::string chosen_and_left_out(const RunResult& run);

}  // namespace tactor
