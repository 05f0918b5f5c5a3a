// The work-precision report of a study: error against run time, a curve a method, and which points nothing undercuts.
#pragma once

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "app/study/table/study.hpp"

namespace tactor {

/// A positive quantity over seeds: the geometric mean, and a geometric standard deviation to each side (NaN where there
/// is one value alone).
struct Spread {
  double centre = 0, low = 0, high = 0;

  [[nodiscard]] bool has_sides() const { return std::isfinite(low) && std::isfinite(high); }
};
/// NaN where there is no value, or one is not above zero.
Spread spread_of(std::span<const double> values);

/// One configuration in one graph, or over all of them, where each seed's value is the geometric mean of theirs. Over
/// the seeds that are done, of all graphs.
struct WorkPoint {
  std::string curve;   ///< the method and the swaps
  std::string values;  ///< the parameters that vary along the curve
  Spread error;        ///< in the unit of the metric
  Spread ms_per_s;     ///< CPU time of the run in ms for a simulated second
  Spread us_per_tick;  ///< CPU time of prediction and interpolation in us for a tick of the device
  bool bound = false;  ///< no method, but what methods cannot be asked for: on no front
  std::size_t seeds_done = 0;
  std::size_t seeds = 0;    ///< that were asked for
  bool judged = true;       ///< by a reference that is finer than the runs; else on no front
  bool front_run = false;   ///< no other method of the graph has a smaller error in as little CPU time of the run
  bool front_tick = false;  ///< nor in as little a tick

  /// Some seeds failed. Such a point is on no front and undercuts nothing: the seeds it lacks may be the hard ones.
  [[nodiscard]] bool incomplete() const { return seeds_done < seeds; }
};

struct WorkGraph {
  std::string graph;  ///< or `all N graphs`
  std::vector<WorkPoint> points;
};

struct WorkPrecision {
  std::string error;                 ///< the metric
  std::string error_label;           ///< what it is, with its unit
  Better better = Better::lower;     ///< of it; where higher is better, the largest errors are on the front
  StudyTime time = StudyTime::both;  ///< which are shown, and have a front
  std::vector<WorkGraph> graphs;
};

/// Which of the points (x, y) no other undercuts: none is smaller in one and not larger in the other. Points that are
/// not finite are not among them.
std::vector<bool> pareto_front(std::span<const double> x, std::span<const double> y);

WorkPrecision work_precision(const Study& study);
std::string work_precision_table(const Study& study, const WorkPrecision& found, std::size_t columns);
nlohmann::ordered_json to_json(const WorkPrecision& found);

/// Writes work_precision_GRAPH.svg and .png into the folder and returns the page with the plots and tables.
std::string write_work_precision(const std::filesystem::path& folder, const Study& study, const WorkPrecision& found);

}  // namespace tactor
