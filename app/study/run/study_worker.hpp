// Does the jobs of a study, in a worker.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "app/study/run/job.hpp"
#include "app/study/run/worker_pool.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

class Registry;

/// One object a worker: it keeps what it has planned, for further seeds of the same case.
class StudyWorker {
 public:
  explicit StudyWorker(Registry& registry) : registry_(registry) {}
  /// Takes a Job as a message, and returns the answer to its kind as one.
  std::string do_job(const std::string& message, const PoolLink& pool);

 private:
  struct Plans {
    Plan own;
    std::optional<Plan> reference;  ///< of the graph that judges it, where that is another
  };

  CaseCheck check(const Job& job);
  WarmUp warm_up(const Job& job, const PoolLink& pool);
  void make_reference(const Job& job, const PoolLink& pool, JobCost& cost);
  RunAnswer run(const Job& job, const PoolLink& pool);
  std::optional<RunRecord> run_repeats(const Job& job, const PoolLink& pool);
  [[nodiscard]] Plan plan_of(const Job& job, const Overrides& overrides) const;
  [[nodiscard]] Plans plans_of(const Job& job);

  Registry& registry_;
  NodeChecks checks_;
  std::map<std::string, Plans> planned_;  // by what tells cases apart
};

}  // namespace tactor
