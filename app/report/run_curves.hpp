// Curves and charts of a run: what reports of one run and of several share.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "app/report/chart.hpp"
#include "app/run/run.hpp"

namespace tactor {

/// Every k-th value, so that a long curve stays light; k keeps about `most` of them.
Curve thinned(const Series& series, std::string name, std::string color, std::size_t most = 3500);

/// What of it is in `range`, s.
Curve cut(const Series& series, std::string name, std::string color, std::pair<double, double> range);

/// The 150 ms in which the reference moves most, where there is one, in s: that is where methods differ.
std::pair<double, double> liveliest_window(const RunResult& run);

/// The axis on which the commanded force varies most in `range`: the one to look at in a zoom.
std::string liveliest_axis(const RunResult& run, std::pair<double, double> range);

/// Force, displacement, contacts and physics rate over the whole run.
std::vector<Chart> four_rows(const RunResult& run);

/// The force along `axis` in `range`, with the reference alone as yet.
Chart zoom_on(const RunResult& run, std::pair<double, double> range, const std::string& axis);

/// The results of physics as they arrived, in points.
Curve arrivals(const RunResult& run, std::pair<double, double> range, const std::string& axis);

}  // namespace tactor
