// Which threads the nodes of a plan step on when the clock is real.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/scheduling.hpp"
#include "framework/graph/chains.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// The threads of one lane.
struct LaneSpec {
  std::string name;  ///< of its threads, at most 15 characters show
  int workers = 1;
  ThreadSettings settings;
};

/// The threads of a run.
struct LanePlan {
  std::vector<LaneSpec> lanes;                          ///< the first is the pool
  std::vector<std::size_t> lane_of;                     ///< by node: index into `lanes`; of no meaning in `realtime`
  std::vector<std::optional<ThreadSettings>> realtime;  ///< by node: the settings of its loop, where it steps in one
  Chains chains;                                        ///< the nodes of each loop
};

/// The pool has as many workers as the graph says, or one a node, at most one a core. Each thread lane has one. A node
/// in the real-time lane that names no core is pinned to the last one that this process may use, where there are
/// several and `realtime_granted`: without SCHED_FIFO it would wait there for whatever else that core has to do. Throws
/// InputError, with the place, for a core beyond `cores`, those of the machine. `usable` is not empty.
LanePlan plan_lanes(const Plan& plan, int cores, const std::vector<int>& usable, bool realtime_granted);
/// On this machine.
LanePlan plan_lanes(const Plan& plan);

/// Throws RunError where the graph says `on_missing_privilege: fail` and the system refuses something to a thread of
/// these lanes or to `timer`, the engine's own. Otherwise, where hardware is driven, one line that says what is refused
/// and what a person feels of it; empty: nothing is refused, or no hardware is driven.
std::string check_privileges(const Plan& plan, const LanePlan& lanes, const ThreadSettings& timer);

}  // namespace tactor
