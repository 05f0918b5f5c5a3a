// Tells of MuJoCo's contacts in our terms.
#pragma once

#include <mujoco/mujoco.h>

#include "framework/core/messages.hpp"
#include "nodes/physics/engine/coupled_engine.hpp"

namespace tactor {

/// Sums the contacts of the last step on the bodies whose flag in `of_tool` is not 0, about the centre of mass of
/// `tool`, where the step began. Call it before the bodies are moved on.
void sum_contacts(const mjModel& m, const mjData& d, const char* of_tool, int tool, EngineTool& sum);

/// Puts the contacts of the last step on the `count` bodies `listed` into `found`, with these bodies where the step
/// began. A contact's stiffness and damping are those of MuJoCo's row for its normal at its distance.
void list_contacts(const mjModel& m, const mjData& d, const int* listed, int count, ContactSet& found);

}  // namespace tactor
