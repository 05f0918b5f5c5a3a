#include "nodes/physics/engine/mujoco_plugin.hpp"

#include "framework/node/plugin.hpp"

namespace tactor {

namespace {
constexpr const char* mujoco_file = "libtactor_mujoco.so";
}  // namespace

bool has_mujoco_plugin() {
  return has_plugin(mujoco_file);
}

const MujocoPlugin& load_mujoco_plugin(const std::string& what_for) {
  return load_plugin<MujocoPlugin>(
      mujoco_file, "tactor_mujoco_plugin",
      what_for +
          " needs the plugin tactor_mujoco (package tactor-mujoco, or a build where Debian's libmujoco-dev is "
          "installed)");
}

}  // namespace tactor
