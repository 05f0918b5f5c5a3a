// A study: graphs by methods by values over seeds, in one table with error and run time beside each other.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/statistics.hpp"
#include "app/study/plan/study_plan.hpp"
#include "app/study/table/comparison.hpp"

namespace tactor {

/// The metrics that ErrorRatio compares.
inline constexpr std::string_view delivered_error = "delivered.force.rms_error_N";
inline constexpr std::string_view one_step_error = "one_step.force.rms_error_N";

/// The RMS errors of a row, or of a configuration over all graphs, as a multiple of those of what it is compared with,
/// by the geometric mean over the seeds that both have; over graphs too, where each seed's ratio is the geometric mean
/// of theirs.
struct ErrorRatio {
  std::optional<GeometricMean> delivered;
  std::optional<GeometricMean> one_step;
};

/// A study that has run. The rows of `comparison` are, for each graph, the configurations in order; each is judged
/// against another of the same graph (StudySpec::baseline).
struct Study {
  StudySpec spec;
  std::vector<StudyConfiguration> configurations;
  Comparison comparison;
  std::vector<ErrorRatio> ratios;              ///< one a row
  std::vector<ErrorRatio> ratios_over_graphs;  ///< one a configuration
  /// How the ratios of the delivered error lie over the seeds, one a row; absent where there is no ratio.
  std::vector<std::optional<SeedSpread>> spreads;
  std::vector<std::optional<SeedSpread>> spreads_over_graphs;  ///< likewise, one a configuration

  /// The mean over the graphs of a metric's mean over the seeds that are done.
  [[nodiscard]] double over_graphs(std::size_t configuration, std::string_view metric) const;
  /// What stands behind the configuration's name in tables over the graphs where a graph, or what it is compared with
  /// there, lacks seeds; else empty.
  [[nodiscard]] std::string incomplete(std::size_t configuration) const;
  [[nodiscard]] const StudyConfiguration& configuration(std::size_t row) const {
    return configurations[row % configurations.size()];
  }
};

/// Judges the runs of the cases.
Study make_study(const StudySpec& spec, Comparison comparison);

/// What is said of the run times of the study.
TimingNote timing_note(const Study& study);
nlohmann::ordered_json to_json(const Study& study);

}  // namespace tactor
