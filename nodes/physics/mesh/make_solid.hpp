// Makes a solid from the content of a mesh file, or says why that is impossible.
#pragma once

#include <string>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_report.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

/// The surface of a solid: closed, manifold, without self-intersections, of triangles with area, counter-clockwise as
/// seen from outside the material (faces of a cavity look into it).
/// The plugin `tactor_cgal` checks and repairs the mesh, as nodes/physics/cgal/mesh_repair.hpp says. Without it,
/// polygons are cut into fans, which suits convex ones only, faces without area are left out, nothing else is repaired
/// or checked, and a warning says so.
/// Throws InputError, beginning with `file`, where there is no such surface.
TriangleMesh make_solid(PolygonSoup soup, const std::string& file, MeshReport& report);

/// What to add to a refusal by make_solid where `tactor mesh repair` may help: `; or try ...`. Empty where not.
std::string repair_hint(const MeshReport& report, const std::string& file);

/// Whether make_solid repairs: the plugin is installed.
bool repairs_meshes();

}  // namespace tactor
