// The entry of the plugin `tactor_mujoco`.
#include "framework/node/abi.hpp"
#include "nodes/physics/engine/mujoco_plugin.hpp"
#include "nodes/physics/mujoco/model_file.hpp"
#include "nodes/physics/mujoco/mujoco_engine.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" const tactor::MujocoPlugin* tactor_mujoco_plugin() {
  static const tactor::MujocoPlugin plugin = {tactor::make_mujoco_engine, tactor::model_bodies};
  return &plugin;
}
