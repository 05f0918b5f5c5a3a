// The steps of mesh_rework.hpp that are dear to compile, each in a file of its own.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// A triangle by its corners.
using Corners = std::array<Vec3, 3>;

/// No point of `from` is farther from the triangles `to` than this; too large by `error` at most, never too small.
/// Triangles that are in both cost no time; those without area are left out. `to` must not be empty.
double largest_gap(const std::vector<Corners>& from, const std::vector<Corners>& to, double error);

/// The distance of each point from the triangles.
std::vector<double> gaps_of(const std::vector<Vec3>& points, const std::vector<Corners>& triangles);

/// Whether each point lies inside a closed surface.
std::vector<bool> inside_of(const std::vector<Vec3>& points, const TriangleMesh& closed);

/// A hole, and what its filling tells of it.
struct Hole {
  Vec3 place;        ///< the middle of its rim's box
  double width = 0;  ///< twice the largest distance of a point of the filling from the rim
  std::size_t edges = 0;
};
struct FilledHoles {
  TriangleMesh mesh;             ///< its first faces are those of the input
  std::vector<Corners> patches;  ///< the triangles that fill the holes
  std::vector<Hole> filled;
  std::vector<Hole> failed;  ///< for which CGAL found no triangles
};
/// Triangulates each hole and refines that to the density of its rim. `mesh` is manifold, open, and consistently
/// oriented.
FilledHoles fill_holes(const TriangleMesh& mesh);

/// Takes out self-intersections of a closed mesh by smoothing and filling anew around them (experimental in CGAL 5.5).
/// Each body by itself. What is left of them has to be looked for.
TriangleMesh untangled(const TriangleMesh& mesh);

/// The union of two closed meshes that look outwards; a mesh without faces where CGAL cannot make it, because one cuts
/// itself or the union is no manifold.
TriangleMesh united(const TriangleMesh& a, const TriangleMesh& b);

/// Of a closed mesh that looks outwards and cuts itself, what bounds the places that it goes round: its parts inside
/// are gone, and nothing else has moved. A mesh without faces where that is not closed or three faces cross in a point.
TriangleMesh outermost(const TriangleMesh& mesh);

/// A closed surface around everything, which no ball of the radius `alpha` from outside enters, `offset` away (CGAL's
/// alpha wrap).
TriangleMesh wrapped_around(const std::vector<Corners>& triangles, double alpha, double offset);

}  // namespace tactor
