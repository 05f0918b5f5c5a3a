// The verb `lean`: searches, and writes the graph with its table.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/results_folder.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

/// What the command line says of `tactor lean`.
struct LeanRequest {
  std::filesystem::path graph;
  Overrides overrides;
  double budget = 0;                    ///< N, RMS
  std::optional<double> torque_budget;  ///< N m, RMS; absent: the force at a lever of 50 mm
  std::string metric = "delivered";     ///< or physics
  std::uint64_t seeds = 1;
  std::int64_t repeats = 3;  ///< runs of each seed whose median counts
  ResultsRequest results;    ///< where the graph is written; absent: out/NAME_lean.yaml
  std::function<bool()> interrupted;
};

/// Writes the leanest graph, and the table of what each step saved beside it, and prints that. Returns the exit code;
/// throws InputError and RunError.
int run_lean(const LeanRequest& request);

}  // namespace tactor
