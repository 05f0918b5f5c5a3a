// The parts that the page of a comparison shares with those of studies.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/report/html_page.hpp"
#include "app/study/table/comparison.hpp"
#include "app/study/table/study.hpp"

namespace tactor {

/// The head of a metric's column, with the definition of the metric: HTML.
std::string head_text(const Comparison& comparison, const Column& column);
/// The deviation of the values, `-` of fewer than two.
std::string deviation(const std::vector<double>& values);
/// A cell for each metric of the row: mean and deviation over the seeds.
void add_metric_cells(std::vector<std::string>& cells, const CompareRow& row);
/// A table of many metrics, which scrolls in its frame on a wide screen.
std::string in_frame(const HtmlTable& table);
/// Which part of the runs is judged, by which definitions, and which direction of an arrow is better.
std::string judged_html(const Comparison& comparison);
/// A table of the metrics that the study names, of one graph; empty where it names none.
std::string named_metrics_html(const Study& study, std::size_t graph);
/// The tests of each row against its baseline, which `against` names. Empty where no row has a baseline.
std::string significance_html(const Comparison& comparison, const std::string& against);
/// The runs that failed, with their messages; empty where none did.
std::string failures_html(const Comparison& comparison);
/// How far run times can be trusted.
std::string timing_html(const TimingNote& timing);

}  // namespace tactor
