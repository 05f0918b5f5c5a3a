// The commands `tactor study` and `tactor compare`: one engine, one table of runs, the files they leave.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/study/prepare_study.hpp"
#include "app/study/spec/study_spec.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

struct ComparedGraph {
  std::filesystem::path file;
  Overrides method{};         ///< laid over it first
  std::string method_name{};  ///< of what is laid over; empty for nothing
};

struct CompareRequest {
  std::vector<ComparedGraph> graphs;
  Overrides overrides;  ///< of all of them
  std::int64_t seeds = 6;
  std::uint64_t first_seed = 1;
  std::int64_t repeats = 1;  ///< of every run, for its run time; one more before them where there are several
  unsigned jobs = 1;         ///< reference runs at once; runs under test go one after the other
  std::filesystem::path out;
  JudgedPart judge = JudgedPart::warm;
  bool brief = false;  ///< prints error, delay, smoothness and run time alone; the files hold everything
};

/// Both return the exit code, and throw InputError and RunError. They fork workers, so the program must have no other
/// thread.
int run_study(const StudyRequest& request);
int run_compare(const CompareRequest& request);

}  // namespace tactor
