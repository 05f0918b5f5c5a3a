// The bunny with as many triangles as wanted.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor::bench {

/// bunny00.off of CGAL's demo data, 0.15 m high along y and centred: decimated where a size is smaller than its own
/// 75,408 triangles, else subdivided (each face into four, and smoothed) until it is reached. Throws InputError where
/// `source` is no mesh, or a result is no solid.
std::vector<TriangleMesh> sized_bunnies(const std::filesystem::path& source, const std::vector<std::size_t>& sizes);

}  // namespace tactor::bench
