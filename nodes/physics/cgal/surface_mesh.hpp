// A mesh as CGAL's halfedge structure, and the repairs of it that are dear to compile, each in a file of its own.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "framework/core/read_budget.hpp"
#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Face = SurfaceMesh::Face_index;
using FaceNumbers = SurfaceMesh::Property_map<Face, std::size_t>;

/// The corners of a triangle, in its direction.
inline std::array<SurfaceMesh::Vertex_index, 3> corners_of(const SurfaceMesh& surface, Face f) {
  const SurfaceMesh::Halfedge_index h = surface.halfedge(f);
  return {surface.target(h), surface.target(surface.next(h)), surface.target(surface.prev(h))};
}

/// Vertices and triangles in the order of the surface, which has no gaps.
TriangleMesh triangles_of(const SurfaceMesh& surface);
PolygonSoup soup_of(const SurfaceMesh& surface);

/// The surface of a mesh, in its order; empty where its faces do not meet as those of a manifold.
SurfaceMesh surface_of(const TriangleMesh& mesh);

/// Turns polygons so that neighbours go through their edges in opposite directions; may make points double. False where
/// the surface has only one side.
bool orient_polygons(std::vector<Point>& points, std::vector<std::vector<std::size_t>>& polygons);

/// The surface of polygons that are a closed manifold and go the same way round. Faces keep their order.
SurfaceMesh surface_of(const std::vector<Point>& points, const std::vector<std::vector<std::size_t>>& polygons);

/// The surface of triangles that are oriented alike, in their order: rims at the same place are joined, and vertices in
/// which parts touch become several at one place.
TriangleMesh stitched(const std::vector<Point>& points, const std::vector<std::vector<std::size_t>>& triangles);

/// A face of very many corners that crosses itself where it is seen along its normal; nothing where there is none. To
/// cut such a face would take time and memory by the square of its corners.
std::optional<Face> tangled_face(const SurfaceMesh& surface);

/// The budget for the checks below of a mesh of this size: their work may grow with the square of its parts.
ReadBudget budget_for_checks(const std::string& file, const PolygonSoup& soup);

/// Cuts polygons of more than three corners; their triangles take over their numbers. False where one cannot be cut.
/// Throws InputError, beginning with `file`, where a polygon has more corners than the budget allows: the work grows
/// with their square.
bool cut_into_triangles(SurfaceMesh& surface, FaceNumbers numbers, const std::string& file, ReadBudget& budget);

/// Takes out vertices that no face has, such as those of faces that are gone.
void remove_isolated_vertices(SurfaceMesh& surface);

/// Flips and collapses edges where that takes away faces without area and leaves the rest as it is. What is left of
/// them has to be looked for.
void remove_flat_faces(SurfaceMesh& surface);

/// Pairs of faces that meet where they are not neighbours, at most `most`. Throws InputError, beginning with `file`,
/// where the boxes of more pairs of faces overlap than the budget allows.
std::vector<std::pair<Face, Face>> self_intersections(const SurfaceMesh& surface, unsigned most,
                                                      const std::string& file, ReadBudget& budget);

/// True where outer shells look outwards and cavities into themselves.
bool is_outward_oriented(const SurfaceMesh& surface);
/// Turns shells so that it is.
void orient_outwards(SurfaceMesh& surface);

/// Collapses edges of a closed mesh until it has `faces` faces or no edge can be collapsed (Garland and Heckbert).
/// Faces turn by less than a right angle in each step.
TriangleMesh collapsed(const TriangleMesh& mesh, std::size_t faces);

}  // namespace tactor
