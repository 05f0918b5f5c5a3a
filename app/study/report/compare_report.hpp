// The page of a comparison: what each method errs and costs, then the force itself, then all figures.
#pragma once

#include <string>

#include "app/study/table/comparison.hpp"

namespace tactor {

/// The report of a comparison, and what is said of its run times. `scene`: see scene_figure.
std::string compare_report(const Comparison& comparison, const TimingNote& timing, const std::string& scene = {});

}  // namespace tactor
