// The chains of a plan: which nodes of the real-time lane share a loop when the clock is real.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

/// Nodes of the real-time lane that are joined by inner edges form a chain and step in one loop. A node that no inner
/// edge joins to another one is a chain of its own.
struct Chains {
  /// By chain, in the order in which they step: devices, then the others, each in the order of the plan.
  std::vector<std::vector<std::size_t>> nodes;
  std::vector<std::optional<std::size_t>> of;  ///< by node: its chain; none outside of the real-time lane
  /// By edge: true if its messages are visible to the nodes that step after the writer in the same tick. Such an edge
  /// joins two nodes of the real-time lane with the same rate and the same policy, priority and core, and at most one
  /// device. It has no delay,
  /// which the engine would count; its policy is not `block`, for which a loop would wait; and its reader is no sink,
  /// because the engine keeps the ramp-down from sinks.
  std::vector<bool> inner;
};

Chains find_chains(const Plan& plan);

/// The chains of two and more nodes that a run of the plan has; none under the virtual clock.
std::vector<std::vector<std::size_t>> shared_loops(const Plan& plan);

/// `device, passivity`: the names of nodes of a plan.
std::string node_names(const Plan& plan, const std::vector<std::size_t>& nodes);

}  // namespace tactor
