// The HTML pages of several runs side by side: a comparison, and a study as tables.
#pragma once

#include <string>

#include "app/study/table/comparison.hpp"
#include "app/study/table/study.hpp"

namespace tactor {

/// The report of a comparison, and what is said of its run times. `scene`: see scene_figure.
std::string compare_report(const Comparison& comparison, const TimingNote& timing, const std::string& scene = {});

/// The report of a study: every graph by every configuration, errors and run times side by side.
std::string study_report(const Study& study);

}  // namespace tactor
