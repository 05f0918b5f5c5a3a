// Writes mesh files: OFF, OBJ, STL and PLY.
#pragma once

#include <string>

#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_formats.hpp"

namespace tactor {

/// The format that the ending of a file name tells. Throws InputError, beginning with `file`, where it tells none.
MeshFormat format_of_ending(const std::string& file);

/// `OFF`, `OBJ`, `STL`, `PLY`.
std::string name_of(MeshFormat format);

/// The file's text, ASCII in every format. Coordinates are written in full, so that reading it gives the same mesh.
std::string mesh_text(const TriangleMesh& mesh, MeshFormat format);

}  // namespace tactor
