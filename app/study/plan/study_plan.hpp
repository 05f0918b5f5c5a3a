// What a study runs: its configurations, and a case for each of them and each graph.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "app/study/plan/run_case.hpp"
#include "app/study/spec/study_spec.hpp"

namespace tactor {

/// One combination of method and varied values.
struct StudyConfiguration {
  std::string method;                                       ///< its name, or empty
  std::vector<std::pair<std::string, std::string>> values;  ///< by axis
  std::vector<Overlay> layers;                              ///< method and swaps
  std::vector<std::string> set;                             ///< `path=value` of the varied parameters
  /// The index of the configuration that it is compared with on the same graph; its own where there is none.
  std::size_t against = 0;
};

/// What the configurations of a study are, without having run.
std::vector<StudyConfiguration> study_configurations(const StudySpec& spec);
/// The metrics that the tables of the study show; none: the usual ones.
std::vector<std::string> shown_metrics(const StudySpec& spec);
/// What is to be run, in the order of Study's rows; `overrides` are laid over what the study says. Throws
/// InputError where they set what it varies.
std::vector<RunCase> study_cases(const StudySpec& spec, const Overrides& overrides);
/// How a configuration is called in tables.
std::string label(const StudyConfiguration& configuration);

}  // namespace tactor
