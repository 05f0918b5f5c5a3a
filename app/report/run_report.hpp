// The HTML page of one run.
#pragma once

#include <string>

#include "app/run/run.hpp"

namespace tactor {

/// The report of one run: the four rows of the paper's figures, a zoom, and every figure. `scene`: see scene_figure.
std::string run_report(const RunResult& run, const std::string& scene = {});

/// What stood for others and what was left out, as an HTML list.
std::string chosen_and_left_out(const RunResult& run);

}  // namespace tactor
