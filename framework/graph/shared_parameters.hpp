// What is told of parameters that are as in another node, where no such node gives them.
#pragma once

#include <string>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

/// A note for each parameter that should be as in the dynamics or the collision (ParamInfo::as_in), and has its own
/// default because the physics of the graph is of another kind, or missing, and has no such parameter.
std::vector<std::string> unshared_parameter_notes(const Plan& plan);

}  // namespace tactor
