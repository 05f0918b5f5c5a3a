// The entry of the plugin `tactor_meshing`.
#include "framework/node/abi.hpp"
#include "nodes/physics/mesh/meshing_plugin.hpp"
#include "nodes/physics/meshing/mesh_rework.hpp"
#include "nodes/physics/meshing/volume_mesh.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" const tactor::MeshingPlugin* tactor_meshing_plugin() {
  static const tactor::MeshingPlugin plugin = {tactor::reworked_solid, tactor::decimated_solid, tactor::volume_mesh};
  return &plugin;
}
