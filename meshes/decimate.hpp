// Closed surfaces brought to an exact number of faces.
#pragma once

#include <cstddef>
#include <string>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include "nodes/scene/mesh.hpp"

namespace tactor {

using SurfaceKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<SurfaceKernel::Point_3>;

/// The surface as lists of vertices and faces, in its own order; takes out what was deleted from it.
TriangleMesh indexed(Surface& surface);

/// Collapses edges of a closed triangulated surface until it has `faces` faces, by the quadrics of M. Garland and
/// P. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997, refusing collapses that turn a
/// normal over. Throws RunError, beginning with `name`, where the result has another count, is open, cuts itself or
/// looks inwards.
TriangleMesh decimate(Surface& surface, std::size_t faces, const std::string& name);

}  // namespace tactor
