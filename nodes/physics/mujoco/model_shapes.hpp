// The geoms of a model of MuJoCo as shapes for pictures.
#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "framework/core/own_scene.hpp"

namespace tactor {

/// `bodies` by their numbers, where the data have them, and the geoms that MuJoCo's own viewer draws at first: those of
/// the groups 0 to 2 that are not transparent, or of all groups where these have none. A shape is called after its
/// geom, else after its body.
OwnScene scene_of_model(const mjModel& m, const mjData& d, const std::vector<int>& bodies);

}  // namespace tactor
