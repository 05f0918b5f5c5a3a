// What the plugin `tactor_cgal` offers to meshes and distances. Nothing else of a run of rigid bodies links CGAL.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_report.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

class SignedDistance;

struct CgalPlugin {
  /// nodes/physics/cgal/mesh_repair.hpp
  TriangleMesh (*repaired_solid)(PolygonSoup soup, const std::string& file, MeshReport& report);
  /// nodes/physics/cgal/exact_distance.hpp
  std::unique_ptr<SignedDistance> (*exact_distance)(const TriangleMesh& mesh);
};

/// Whether the plugin is installed; does not load it.
bool has_cgal_plugin();

/// Loads the plugin. Throws InputError, beginning with `what_for`, where it is not installed or belongs to another
/// build.
const CgalPlugin& load_cgal_plugin(std::string_view what_for);

}  // namespace tactor
