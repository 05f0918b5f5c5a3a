// Whether what a node sets while a run goes on can be made, and is felt as it is set.
#pragma once

#include "framework/graph/plan.hpp"

namespace tactor {

/// Refuses settings (NodeInfo::sets) that cannot be made, or do not have the effect they ask for. Settings of one path
/// are made together, one after the other in their order; where a parameter comes up again, the next group begins.
/// Groups that set the same parameters take turns: the conditions of an experiment, say, or its levels. Those that set
/// others hold at the same time. So what is checked is each combination of a group of each kind:
/// - Its settings can be made one by one, from the values of the graph and from each other combination.
/// - It is felt as it is set. A node notes which parameter limits another one (NodeContext::note_limit). That is an
///   error where the limited parameter is set, because other values would feel alike. It is none where only the limit
///   is set, because that is felt. Any other note is an error where the values of the graph do not make it.
/// Throws YamlError with the places of all such settings, one error for each place and node.
void check_effects(const Plan& plan);

}  // namespace tactor
