// Repairs and checks what a mesh file lists, with exact predicates.
#pragma once

#include <string>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_report.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

/// The surface of a solid, as make_solid promises it.
/// Repaired, and told in `report.repairs`: isolated, duplicated and repeated vertices, duplicated faces, faces without
/// area, faces that look the wrong way, polygons of more than three corners. What needs no repair keeps its order.
/// Told in `report.warnings`: very thin faces, very many faces.
/// Throws InputError, beginning with `file`, with the fault, its place (coordinates in the file's unit, faces counted
/// from 0 in the file's order) and the remedy: no faces, open, more than two faces at an edge, parts that touch in a
/// vertex, one-sided, cut by itself, without volume.
/// The checks are those of CGAL's package Polygon Mesh Processing.
TriangleMesh repaired_solid(PolygonSoup soup, const std::string& file, MeshReport& report);

}  // namespace tactor
