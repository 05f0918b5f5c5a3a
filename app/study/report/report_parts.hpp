// What the page of a comparison and the page of a study have in common.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/study/table/comparison.hpp"
#include "app/study/table/study.hpp"

namespace tactor {

/// What a table's head says of a metric, with the definition: HTML.
std::string head_text(const Comparison& comparison, const Column& column);
/// The deviation of the values, `-` of fewer than two.
std::string deviation(const std::vector<double>& values);
/// Which part of the runs is judged, by which definitions, and which direction of an arrow is better.
std::string judged_html(const Comparison& comparison);
/// What each configuration has in one graph of the metrics that the study names; empty where it names none.
std::string named_metrics_html(const Study& study, std::size_t graph);
/// Every row that is compared with another; `against` says which that is. Empty where there is none.
std::string significance_html(const Comparison& comparison, const std::string& against);
/// The runs that failed, with their messages; empty where none did.
std::string failures_html(const Comparison& comparison);
/// What is said of run times.
std::string timing_html(const TimingNote& timing);

}  // namespace tactor
