// Closed surfaces brought to an exact number of faces.
#pragma once

#include <cstddef>
#include <string>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Collapses edges of a closed triangulated surface until it has `faces` faces, by the quadrics of M. Garland and
/// P. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997, refusing collapses that turn a
/// normal over. Throws RunError, beginning with `name`, where the source is not closed or has too few faces, or where
/// the result has another count, is open, cuts itself or looks inwards.
TriangleMesh decimate(const TriangleMesh& source, std::size_t faces, const std::string& name);

}  // namespace tactor
