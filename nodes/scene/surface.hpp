// A mesh as CGAL's halfedge structure, and the repairs of it that are dear to compile, each in a file of its own.
#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "nodes/scene/mesh.hpp"
#include "nodes/scene/polygon_soup.hpp"

namespace tactor {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;
using Face = Surface::Face_index;
using FaceNumbers = Surface::Property_map<Face, std::size_t>;

/// The corners of a triangle, in its direction.
inline std::array<Surface::Vertex_index, 3> corners_of(const Surface& surface, Face f) {
  const Surface::Halfedge_index h = surface.halfedge(f);
  return {surface.target(h), surface.target(surface.next(h)), surface.target(surface.prev(h))};
}

/// Vertices and triangles in the order of the surface, which has no gaps.
TriangleMesh triangles_of(const Surface& surface);
PolygonSoup soup_of(const Surface& surface);

/// The surface of a mesh, in its order; empty where its faces do not meet as those of a manifold.
Surface surface_of(const TriangleMesh& mesh);

/// Turns polygons so that neighbours go through their edges in opposite directions; may make points double. False where
/// the surface has only one side.
bool orient_polygons(std::vector<Point>& points, std::vector<std::vector<std::size_t>>& polygons);

/// The surface of polygons that are a closed manifold and go the same way round. Faces keep their order.
Surface surface_of(const std::vector<Point>& points, const std::vector<std::vector<std::size_t>>& polygons);

/// Cuts polygons of more than three corners; their triangles take over their numbers. False where one cannot be cut.
bool cut_into_triangles(Surface& surface, FaceNumbers numbers);

/// Takes out vertices that no face has, such as those of faces that are gone.
void remove_isolated_vertices(Surface& surface);

/// Flips and collapses edges where that takes away faces without area and leaves the rest as it is. What is left of
/// them has to be looked for.
void remove_flat_faces(Surface& surface);

/// Pairs of faces that meet where they are not neighbours, at most `most`.
std::vector<std::pair<Face, Face>> self_intersections(const Surface& surface, unsigned most);

/// True where outer shells look outwards and cavities into themselves.
bool is_outward_oriented(const Surface& surface);
/// Turns shells so that it is.
void orient_outwards(Surface& surface);

}  // namespace tactor
