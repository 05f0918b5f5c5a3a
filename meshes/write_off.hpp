// Writes a mesh as ASCII OFF.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Writes the mesh with all digits and `comment` (one line) below the header. Throws RunError where it cannot.
void write_off(const std::filesystem::path& path, const TriangleMesh& mesh, const std::string& comment);

}  // namespace tactor
