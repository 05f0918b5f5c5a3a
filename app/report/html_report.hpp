// Self-contained HTML pages: one run, or several pipelines side by side.
#pragma once

#include <string>
#include <vector>

#include "app/run/run.hpp"
#include "app/study/compare.hpp"
#include "app/study/study.hpp"

namespace tactor {

/// The report of one run: the four rows of the paper's figures, a zoom, and every figure.
std::string run_report(const RunResult& result);

/// The report of a comparison, and what is said of its run times.
std::string compare_report(const Comparison& comparison, const TimingNote& timing);

/// The report of a study: every graph by every setting, errors and run times side by side.
std::string study_report(const Study& study);

}  // namespace tactor
