// Since when all nodes of a run work as they go on to.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// When the nodes of a run were warm (Node::warm_since).
struct Warmth {
  std::optional<Time> since = Time{};  ///< all of them; zero: from the start; nothing: one of them never was
  std::string last;  ///< the node that was the last, or one that never was; empty: none had to warm up
  std::string when;  ///< what had to happen there: `its window is full`
};

/// Whether the plan has a node that is not warm from the start, or may not be.
bool has_to_warm_up(const Plan& plan);

/// Of nodes that have run.
Warmth warmth_of(const PlanNodes& nodes);

/// Runs the plan under the virtual clock until all nodes are warm, or to its end. `go_on` is asked every 10 ms of
/// virtual time; where it says no, RunError("interrupted") is thrown.
Warmth find_warmth(const Plan& plan, const std::function<bool()>& go_on = {});

}  // namespace tactor
