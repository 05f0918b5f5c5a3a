// What a study makes of its runs when they are there: tables, files and the report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/study/run/run_cases.hpp"
#include "app/study/spec/study_spec.hpp"
#include "app/study/table/comparison.hpp"

namespace tactor {

struct FinishOptions {
  std::filesystem::path folder;  ///< of the results
  std::vector<std::uint64_t> seeds;
  unsigned jobs = 1;                  ///< cells of a map that are run anew at once
  std::string interrupted;            ///< what is said where somebody ends it
  std::vector<std::string> warnings;  ///< beside those that the runs give rise to
  std::vector<std::string> where;     ///< sentences on where the runs were made, after those that the runs tell
  std::string runner = "{}";          ///< JSON: what study.json tells of the runner beside what the outcome has
};

/// Prints the tables and writes study.csv, run_times.csv, study.h5, study.json, report.html and what belongs to the
/// study's kind of report. Returns the exit code. Throws RunError where it was interrupted or the disk refuses.
int finish_study(const StudySpec& spec, std::vector<RunCase> cases, CasesOutcome outcome, Registry& registry,
                 const FinishOptions& options);

/// Tells on standard error which runs failed. Returns the exit code: 0 where none did.
int told_failures(const Comparison& comparison);

}  // namespace tactor
