// Makes solids of meshes that mesh_repair.hpp refuses, and tells what changed and by how far the surface moved.
#pragma once

#include <cstddef>
#include <string>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_change.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

/// A solid that repaired_solid accepts, made of what a file lists: merges vertices of open edges, joins edges that have
/// a vertex more on one side, takes out loose and inner faces, fills holes, parts what touches in a vertex or an edge,
/// unites bodies that overlap, takes out self-intersections, and turns faces outwards.
/// Throws InputError, beginning with `file`, with what is left and what to do.
MeshChange reworked_solid(PolygonSoup soup, const std::string& file, const RepairOptions& options);

/// The solid with `faces` faces, or one less, because a closed surface has an even number. Throws InputError, beginning
/// with `file`, where it has fewer already or edges cannot be collapsed so far.
MeshChange decimated_solid(const TriangleMesh& solid, std::size_t faces, const std::string& file);

}  // namespace tactor
