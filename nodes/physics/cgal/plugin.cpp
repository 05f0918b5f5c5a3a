// The entry of the plugin `tactor_cgal`.
#include "framework/node/abi.hpp"
#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/cgal/mesh_repair.hpp"
#include "nodes/physics/mesh/cgal_plugin.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" const tactor::CgalPlugin* tactor_cgal_plugin() {
  static const tactor::CgalPlugin plugin = {
      tactor::repaired_solid,
      [](const tactor::TriangleMesh& mesh) -> std::unique_ptr<tactor::SignedDistance> {
        return std::make_unique<tactor::ExactDistance>(mesh);
      },
  };
  return &plugin;
}
