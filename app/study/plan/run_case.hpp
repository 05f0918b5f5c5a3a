// A graph with what is laid over it, to be run with every seed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "framework/graph/spec.hpp"

namespace tactor {

/// From when on the runs of a group of cases are judged.
struct JudgedFrom {
  Time from{};          ///< before `settle`; zero: from the start
  std::size_t run = 0;  ///< the number of the run that was warm last, where `last` is not empty
  std::string last{};   ///< that run, and its node: `bunny refit, seed 1003: refit`; empty: all are warm from the start
  bool cold = false;    ///< runs are judged from their start although a node of them has to warm up
};

/// What is run with every seed.
struct RunCase {
  std::filesystem::path graph;
  Overrides overrides{};                 ///< the seed of a run comes after them
  std::string configuration{};           ///< how it differs from other cases of the same graph, or empty
  std::size_t against = 0;               ///< the case that it is compared with; itself where there is none
  std::optional<Overrides> reference{};  ///< of the graph whose reference run judges it; absent: its own
  /// Of recordings that judge its runs instead of reference runs, as recording_of takes it; empty: reference runs do.
  std::string reference_recording{};
  std::size_t group = 0;  ///< cases of one group are compared with each other, and judged on one interval
  JudgedFrom judged{};    ///< found before the first run
  Overrides unvaried{};   ///< the overrides without what a study varies
  std::string unlike{};   ///< how more than its method differs from the first case, a sentence; empty: not at all
};

/// `graph configuration`.
std::string case_name(const std::string& graph, const std::string& configuration);
/// `graph configuration, seed 3`.
std::string run_name(const std::string& graph, const std::string& configuration, std::uint64_t seed);

}  // namespace tactor
