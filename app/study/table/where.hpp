// Where the runs of a study were made, in sentences.
#pragma once

#include <string>
#include <vector>

#include "app/study/table/comparison.hpp"

namespace tactor {

/// Machines, processors and core hours; empty where no run tells.
std::vector<std::string> where_runs_were_made(const std::vector<RunRecord>& records);
/// `3.4 core hours`, or seconds where there are few.
std::string core_time(double seconds);
/// What a comparison knows of it, for the end of a page; empty for nothing.
std::string where_html(const Comparison& comparison);

}  // namespace tactor
