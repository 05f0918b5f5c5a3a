// Loads the solid that a mesh file describes, from the file or from the cache.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/user_folders.hpp"
#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/mesh_formats.hpp"
#include "nodes/physics/mesh/mesh_report.hpp"

namespace tactor {

struct SolidFile {
  TriangleMesh mesh;               ///< in the unit and frame of the file
  MeshReport report;               ///< the same whether it comes from the cache or not
  std::vector<std::string> notes;  ///< troubles of the cache
};

/// Reads an OFF, OBJ, STL or PLY file (mesh_formats.hpp) and makes a solid of it (mesh_repair.hpp). The solid is kept
/// in `cache_folder` under the content of the file, because the checks take about half a second for 20,000 faces.
/// In a build without CGAL nothing is repaired or checked, polygons are cut into fans, and a warning says so; what
/// comes of it is kept apart from what a build with CGAL keeps. Throws InputError where the file cannot be read or
/// describes no solid.
SolidFile load_solid(const std::filesystem::path& path,
                     const std::filesystem::path& cache_folder = default_cache_folder());

/// What a mesh file lists, unrepaired. Throws InputError where the file cannot be read.
struct MeshFile {
  MeshFormat format = MeshFormat::off;
  PolygonSoup soup;  ///< in the unit and frame of the file
};
MeshFile read_mesh_file(const std::filesystem::path& path);

/// What the cache keeps of a solid, in the layout of this machine, and back. Nothing where the bytes have another
/// layout or an index or coordinate is out of range, so that the mesh may be used without a further look.
std::string to_bytes(const SolidFile& solid);
std::optional<SolidFile> solid_from_bytes(std::string_view bytes);

}  // namespace tactor
