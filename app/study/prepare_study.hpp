// What the command line asks of a study, and what its runs are then, wherever they are made.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "app/study/plan/run_case.hpp"
#include "app/study/run/planned_cases.hpp"
#include "app/study/spec/study_spec.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

struct StudyRequest {
  std::filesystem::path file;
  Overrides overrides;
  std::optional<std::int64_t> seeds;
  std::optional<std::uint64_t> first_seed;
  std::optional<std::int64_t>
      repeats;  ///< of every run, for its run time; one more before them where there are several
  unsigned jobs = 1;
  std::optional<std::filesystem::path> out;  ///< absent: out/NAME
  bool resume = false, overwrite = false;
  bool is_short = false;
  std::optional<JudgedPart> judge;  ///< absent: the study's
  /// Called when its graphs have been read and nothing of the folder has been replaced yet; may be empty.
  std::function<void()> before_runs{};
};

/// A study with the command line laid over it, before its graphs are read.
struct PreparedStudy {
  StudySpec spec;
  std::vector<RunCase> cases;
  CasesSettings settings;
  std::filesystem::path folder;  ///< of the results; nothing has been made there
};

/// Throws InputError where the study file or the options are wrong, or where the folder holds results of another
/// command.
PreparedStudy prepare_study(const StudyRequest& request);

std::vector<std::uint64_t> seeds_from(std::uint64_t first, std::int64_t count);

}  // namespace tactor
