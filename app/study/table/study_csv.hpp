// The runs of a study as CSV.
#pragma once

#include <string>

#include "app/study/table/study.hpp"

namespace tactor {

/// A line a run: graph, method, varied values, seed, status, then the metrics, which no run time is among: the same
/// bytes whatever the machine did beside.
std::string study_csv(const Study& study);
/// A line a run in the same order: what took how long.
std::string run_times_csv(const Study& study);

}  // namespace tactor
