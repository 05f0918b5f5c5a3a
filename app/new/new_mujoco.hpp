// Writes a project around a model of MuJoCo.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nodes/physics/engine/mujoco_plugin.hpp"

namespace tactor {

struct NewMujocoRequest {
  std::string name;              ///< see new_project
  std::filesystem::path model;   ///< a file .xml, which the project reads where it lies
  std::string tool;              ///< its body that the hand moves; empty: choose_tool
  std::filesystem::path folder;  ///< in which the project's folder is made
};

/// The body that the hand moves where nobody says which: one called tool, ee, end_effector or gripper, in this order,
/// else the only one, of those that the coupling can move. Throws InputError with the bodies of the model where there
/// is none, or several. `model`: for the message.
std::string choose_tool(const std::vector<ModelBody>& bodies, const std::filesystem::path& model);

/// Writes the folder, whose graph takes the tool to the nearest surface, and returns its files. Throws InputError as
/// new_project does; where there is no plugin for MuJoCo; where MuJoCo cannot read the model; and where the coupling
/// cannot move the tool.
std::vector<std::filesystem::path> new_mujoco(const NewMujocoRequest& request);

}  // namespace tactor
