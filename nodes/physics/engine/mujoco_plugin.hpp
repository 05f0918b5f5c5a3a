// What the plugin `tactor_mujoco` offers. Nothing else links MuJoCo.
#pragma once

#include <memory>
#include <string>

#include "nodes/physics/engine/coupled_engine.hpp"

namespace tactor {

struct MujocoPlugin {
  /// nodes/physics/mujoco/mujoco_engine.hpp
  std::unique_ptr<CoupledEngine> (*engine)(const EngineModel& model);
};

/// Whether the plugin is installed; does not load it.
bool has_mujoco_plugin();

/// Loads the plugin. Throws InputError, beginning with `what_for`, where it is not installed or belongs to another
/// build.
const MujocoPlugin& load_mujoco_plugin(const std::string& what_for);

}  // namespace tactor
