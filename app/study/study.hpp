// A study: graphs by methods by values over seeds, in one table with error and run time beside each other.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/statistics.hpp"
#include "app/study/compare.hpp"
#include "framework/graph/study.hpp"

namespace tactor {

/// The RMS errors of a row, or of a setting over all graphs, as a multiple of those of what it is judged against, by
/// the geometric mean over the seeds that both have; over graphs too, where each seed's ratio is the geometric mean of
/// theirs.
struct ErrorRatio {
  std::optional<GeometricMean> delivered;
  std::optional<GeometricMean> one_step;
};

/// One combination of method and varied values.
struct StudySetting {
  std::string method;                                       ///< its name, or empty
  std::vector<std::pair<std::string, std::string>> values;  ///< by axis
  ErrorRatio over_graphs;
  std::vector<Overlay> layers;   ///< method and swaps
  std::vector<std::string> set;  ///< `path=value` of the varied parameters
  /// The index of the setting that it is judged against on the same graph; its own where there is none.
  std::size_t against = 0;
};

/// A study that has run. The rows of `comparison` are, for each graph, the settings in order; each is judged against
/// another of the same graph (StudySpec::baseline).
struct Study {
  StudySpec spec;
  std::vector<StudySetting> settings;
  Comparison comparison;
  std::vector<ErrorRatio> ratios;  ///< one a row

  /// The mean over the graphs of a figure's mean over the seeds that are done.
  [[nodiscard]] double over_graphs(std::size_t setting, std::string_view figure) const;
  /// What stands behind the setting's name in tables over the graphs where a graph, or what it is judged against there,
  /// lacks seeds; else empty.
  [[nodiscard]] std::string incomplete(std::size_t setting) const;
  [[nodiscard]] const StudySetting& setting(std::size_t row) const { return settings[row % settings.size()]; }
};

/// What the settings of a study are, without having run.
std::vector<StudySetting> study_settings(const StudySpec& spec);
/// The figures that the tables of the study show; none: the usual ones.
std::vector<std::string> shown_figures(const StudySpec& spec);
/// What is to be run, in the order of Study's rows; `overrides` are laid over what the study says. Throws
/// InputError where they set what it varies.
std::vector<RunCase> study_cases(const StudySpec& spec, const Overrides& overrides);
/// Judges the runs of the cases.
Study make_study(const StudySpec& spec, Comparison comparison);

/// `0.707 [0.650, 0.769]`, with `over 9 seeds` where these are fewer than the `seeds` of the study; `-` for no ratio,
/// and for the interval where there is one seed alone.
std::string ratio_text(const std::optional<GeometricMean>& ratio, std::size_t seeds);
/// `; ratios are to method hold with the same tool.stiffness`; empty where nothing is judged against anything.
std::string ratios_text(const StudySpec& spec);
/// How a setting is called in tables.
std::string label(const StudySetting& setting);

/// A line a run: graph, method, varied values, seed, status, then the figures, which no run time is among: the same
/// bytes whatever the machine did beside.
std::string study_csv(const Study& study);
/// A line a run in the same order: what took how long.
std::string run_times_csv(const Study& study);
/// What is said of the run times of the study.
TimingNote timing_note(const Study& study);
nlohmann::ordered_json to_json(const Study& study);
/// What `tactor study` prints, in so many columns: every graph's settings, then the settings over all graphs.
std::string study_table(const Study& study, std::size_t columns);

}  // namespace tactor
