// Whether the safety gate of a device lets the force through from one result of physics to the next.
#pragma once

#include <string>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

/// The longest that a step costs by its model; of a cost by items without a `max`, that of a step without any. Zero
/// where the model declares no cost.
Duration longest(const CostModel& cost);

/// A note for each device whose force comes from physics that may, by the costs that its graph imposes, take longer for
/// a result than the device waits: the place, the time, and the parameters to set to what.
std::vector<std::string> slow_physics_notes(const Plan& plan);

}  // namespace tactor
