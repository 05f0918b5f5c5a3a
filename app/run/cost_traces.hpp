// What the steps of a run took, as files that a graph reads as costs.
#pragma once

#include <filesystem>

#include "app/run/run.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// A folder with a file NODE.csv for each node outside of the real-time lane that stepped: in s, a line a step, in
/// order, as `cost: {trace: NODE.csv}` reads it. The lines at its head, which begin with #, say the graph, the date and
/// the machine.
class CostTraces {
 public:
  /// Makes the folder. Throws InputError where it is there already, where it cannot be made, and where the plan imposes
  /// the costs that it declares, so that steps do not take what they take.
  CostTraces(std::filesystem::path folder, const Plan& plan);
  /// Where nothing was written, no folder stays.
  ~CostTraces();
  CostTraces(const CostTraces&) = delete;
  CostTraces& operator=(const CostTraces&) = delete;

  /// Writes the times of a run that was made with RunOptions::keeps_step_times. Throws RunError where the disk refuses,
  /// or where a live run lost some of them.
  void write(const RunResult& result) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace tactor
