// What the plugin `tactor_mujoco` offers. Nothing else links MuJoCo.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "nodes/physics/engine/coupled_engine.hpp"

namespace tactor {

/// A body of a model that has a name.
struct ModelBody {
  std::string name;
  std::string joints;      ///< those that it hangs by: `free joint`, `2 hinge joints on body 'arm'`, `no joint`
  bool is_usable = false;  ///< the coupling can move it: it may be a tool
};

struct MujocoPlugin {
  /// nodes/physics/mujoco/mujoco_engine.hpp
  std::unique_ptr<CoupledEngine> (*engine)(const EngineModel& model);
  /// nodes/physics/mujoco/model_file.hpp
  std::vector<ModelBody> (*bodies)(const std::filesystem::path& file);
};

/// Whether the plugin is installed; does not load it.
bool has_mujoco_plugin();

/// Loads the plugin. Throws InputError, beginning with `what_for`, where it is not installed or belongs to another
/// build.
const MujocoPlugin& load_mujoco_plugin(const std::string& what_for);

}  // namespace tactor
