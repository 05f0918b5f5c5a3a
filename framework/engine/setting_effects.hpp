// Whether what a node sets while a run goes on is felt as it is set.
#pragma once

#include "framework/graph/plan.hpp"

namespace tactor {

/// Refuses settings (NodeInfo::sets) that do not have the effect they ask for. The settings of one path are made
/// together, and the nodes they change are checked as they then are. What such a node notes of its parameters, and
/// does not note of those in the graph, is an error: that a limit holds a stiffness down, say, because then different
/// settings feel alike. Throws YamlError with the places of all such settings.
void check_effects(const Plan& plan);

}  // namespace tactor
