// Curves and charts of a run: what reports of one run and of several share.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/report/chart.hpp"
#include "app/run/run.hpp"

namespace tactor {

/// At most about 3,500 of its values from that time on, with the least and the largest of each piece (see Envelope).
Curve thinned(const Series& series, std::string name, std::string color, double from_s = 0);

/// What of it is in `range`, s.
Curve cut(const Series& series, std::string name, std::string color, std::pair<double, double> range);

/// The 150 ms of the judged interval in which the reference moves most, where there is one, in s: that is where methods
/// differ.
std::pair<double, double> liveliest_window(const RunResult& run);

/// The axis on which the commanded force varies most in `range`: the one to look at in a zoom.
std::string liveliest_axis(const RunResult& run, std::pair<double, double> range);

/// The force over the whole run, of each device where no node judges it; no chart where nothing tells it.
std::optional<Chart> force_over_time(const RunResult& run, const std::string& color);

/// The same in the interval that is judged.
std::optional<Chart> judged_force_over_time(const RunResult& run, const std::string& color);

/// The norm of the delivered force's error in the interval that is judged, and what a hand notices at the reference's
/// force; no chart without a reference.
std::optional<Chart> error_over_time(const RunResult& run, const std::string& color);

/// Force, displacement, safety gate, contacts and physics rate over the whole run, of what the run tells. The gate is
/// there where the run was live or something kept the force out.
std::vector<Chart> run_rows(const RunResult& run, const std::string& color);

/// The force along `axis` in `range`, with the reference alone as yet.
Chart zoom_on(const RunResult& run, std::pair<double, double> range, const std::string& axis);

/// The results of physics as they arrived, in points.
Curve arrivals(const RunResult& run, std::pair<double, double> range, const std::string& axis);

}  // namespace tactor
