#include "nodes/physics/mesh/meshing_plugin.hpp"

#include "framework/node/plugin.hpp"

namespace tactor {

const MeshingPlugin& load_meshing_plugin(std::string_view what_for) {
  return load_plugin<MeshingPlugin>(
      "libtactor_meshing.so", "tactor_meshing_plugin",
      std::string(what_for) +
          " needs the plugin tactor_meshing (package tactor-cgal, or a build of the target tactor_meshing with "
          "-DTACTOR_WITH_CGAL=ON)");
}

}  // namespace tactor
