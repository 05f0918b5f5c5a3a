// Makes a solid of what a mesh file lists, or says why there is none.
#pragma once

#include <string>

#include "nodes/scene/mesh.hpp"
#include "nodes/scene/mesh_report.hpp"
#include "nodes/scene/polygon_soup.hpp"

namespace tactor {

/// The surface of a solid: closed, manifold, without self-intersections, of triangles with area, counter-clockwise as
/// seen from outside the material (faces of a cavity look into it).
/// Mended, and told in `report.repairs`: isolated, duplicated and repeated vertices, duplicated faces, faces without
/// area, faces that look the wrong way, polygons of more than three corners. What needs no mending keeps its order.
/// Told in `report.warnings`: very thin faces, very many faces.
/// Throws InputError, beginning with `file`, with the fault, its place (coordinates in the file's unit, faces counted
/// from 0 in the file's order) and the mend: no faces, open, more than two faces at an edge, parts that touch in a
/// vertex, one-sided, cut by itself, without volume.
/// The checks are CGAL's, with exact predicates (package Polygon Mesh Processing). A build without CGAL cuts polygons
/// into fans, which suits convex ones only, repairs and checks nothing else, and warns of that.
TriangleMesh make_solid(PolygonSoup soup, const std::string& file, MeshReport& report);

/// False in a build without CGAL.
bool repairs_meshes();

}  // namespace tactor
