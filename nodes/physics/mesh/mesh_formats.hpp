// Readers of mesh files: OFF, OBJ, STL and PLY.
#pragma once

#include <string>
#include <string_view>

#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

enum class MeshFormat { off, obj, stl, ply };

/// The format of a file: by what it begins with, or else by the end of its name (`.off`, `.obj`, `.stl`, `.ply`, in any
/// case). Throws InputError, beginning with `file`, where neither tells.
MeshFormat mesh_format(const std::string& file, std::string_view bytes);

/// Each reads a whole file. All are strict, because a mesh that was read wrongly pushes wrongly: they throw InputError
/// with `file:line` (text) or the number of the face or vertex, counted from 0 (binary), where a number is none or not
/// finite, an index is out of range, a polygon has fewer than three corners, counts do not fit, or there is text after
/// the end. They take memory in proportion to the bytes that are there, whatever counts a header says.

/// ASCII OFF, COFF and NOFF (colours and normals are left out).
PolygonSoup read_off(const std::string& file, std::string_view bytes);
/// Wavefront OBJ: vertices and faces; normals, textures, groups and materials are left out.
PolygonSoup read_obj(const std::string& file, std::string_view bytes);
/// STL, ASCII or binary. Each face has three points of its own.
PolygonSoup read_stl(const std::string& file, std::string_view bytes);
/// PLY 1.0, ASCII or binary of either byte order: `x`, `y`, `z` of `vertex` and `vertex_indices` or `vertex_index` of
/// `face`; everything else is left out.
PolygonSoup read_ply(const std::string& file, std::string_view bytes);

/// By the reader of that format.
PolygonSoup read_mesh(const std::string& file, MeshFormat format, std::string_view bytes);

}  // namespace tactor
