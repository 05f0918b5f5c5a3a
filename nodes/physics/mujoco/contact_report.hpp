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
/// began. The tool is the first of them, together with the bodies whose flag in `of_tool` is not 0. Distances count
/// from MuJoCo's margin, from which on its contacts push, and so do the points. A contact has the law of MuJoCo's rows
/// for it at its distance: stiffness, damping and inertia along the normal, and of an elliptic cone its creep and lift
/// too.
void list_contacts(const mjModel& m, const mjData& d, const char* of_tool, const int* listed, int count,
                   ContactSet& found);

}  // namespace tactor
