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
  Overrides files;                                          ///< the method and what is swapped in
  Overrides set;                                            ///< the varied parameters
  /// The index of the configuration that it is compared with on the same graph; its own where there is none.
  std::size_t against = 0;
};

/// What the configurations of a study are, without having run.
std::vector<StudyConfiguration> study_configurations(const StudySpec& spec);
/// The metrics that the tables of the study show; none: the usual ones.
std::vector<std::string> shown_metrics(const StudySpec& spec);
/// What is laid over a graph: `files` of a configuration, then what the study sets in every run, then `set` of the
/// configuration, then what the command line says.
Overrides overrides_of(const StudySpec& spec, const Overrides& files, const Overrides& set,
                       const Overrides& command_line);
/// What is to be run, in the order of Study's rows. Throws InputError where the command line sets what the study
/// varies, or the seed.
std::vector<RunCase> study_cases(const StudySpec& spec, const Overrides& command_line);
/// Throws InputError where the command line sets the seed, which studies and comparisons choose run by run.
void refuse_seed(const Overrides& command_line);
/// How a configuration is called in tables.
std::string label(const StudyConfiguration& configuration);

}  // namespace tactor
