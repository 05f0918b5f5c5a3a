// How long the runs of a study take, by a few of them made here.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "app/study/cluster/cluster_plan.hpp"

namespace tactor {

class WorkerPool;

struct Measured {
  UnitCosts costs;
  std::vector<std::string> depends_on_processor;  ///< of what was made, as processor_dependence()
};

/// Makes a few runs, with their reference runs and their warm-up, spread over graphs and configurations. A case that
/// was not tried takes what the nearest one of its graph took, and a graph that was not tried what all took on average.
/// Throws RunError where it was interrupted.
Measured measure_costs(const PlannedCases& planned, WorkerPool& pool, const std::filesystem::path& cache_folder,
                       unsigned at_once, const std::function<void(double share, const std::string& what)>& progress,
                       const std::function<void(const std::string& note)>& note);

}  // namespace tactor
