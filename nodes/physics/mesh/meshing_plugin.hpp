// What the plugin `tactor_meshing` offers to `tactor mesh` and to soft bodies: repair, coarser meshes, and tetrahedra.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_change.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"
#include "nodes/physics/mesh/tet_mesh.hpp"
#include "nodes/physics/mesh/volume_fineness.hpp"

namespace tactor {

struct MeshingPlugin {
  /// nodes/physics/meshing/mesh_rework.hpp
  MeshChange (*reworked_solid)(PolygonSoup soup, const std::string& file, const RepairOptions& options);
  MeshChange (*decimated_solid)(const TriangleMesh& solid, std::size_t faces, const std::string& file);
  /// nodes/physics/meshing/volume_mesh.hpp
  TetMesh (*volume_mesh)(const TriangleMesh& solid, const VolumeFineness& fineness, const std::string& file);
};

/// Loads the plugin. Throws InputError, beginning with `what_for`, where it is not installed or belongs to another
/// build.
const MeshingPlugin& load_meshing_plugin(std::string_view what_for);

}  // namespace tactor
