// The commands `tactor study` and `tactor compare`: one engine, one table of runs, the files they leave.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "framework/graph/spec.hpp"

namespace tactor {

class Supervisor;

/// What both commands get from their surroundings.
struct StudyConsole {
  std::function<bool()> interrupted;  ///< may be asked by several threads at once
  Supervisor* supervisor = nullptr;   ///< as CasesOptions::supervisor
};

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
};

struct CompareRequest {
  std::vector<std::filesystem::path> graphs;
  Overrides overrides;
  std::int64_t seeds = 6;
  std::uint64_t first_seed = 1;
  std::int64_t repeats = 1;  ///< of every run, for its run time; one more before them where there are several
  unsigned jobs = 1;         ///< reference runs at once; runs under test go one after the other
  std::filesystem::path out;
};

/// Does the work in a process of its own, and in a new one where a run has crashed that; returns the exit code.
/// `threads`: runs at once.
int supervised(unsigned threads, const std::function<int(const StudyConsole&)>& work);

/// Both return the exit code, and throw InputError and RunError.
int run_study(const StudyRequest& request, const StudyConsole& console);
int run_compare(const CompareRequest& request, const StudyConsole& console);

}  // namespace tactor
