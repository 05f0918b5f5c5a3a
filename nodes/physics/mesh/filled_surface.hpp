// Fills closed surfaces with tetrahedra, once: what comes of it is kept in the cache.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/user_folders.hpp"
#include "nodes/physics/mesh/mesh.hpp"
#include "nodes/physics/mesh/tet_mesh.hpp"
#include "nodes/physics/mesh/volume_fineness.hpp"

namespace tactor {

/// The tetrahedra in `surface`, as the plugin tactor_meshing makes them (nodes/physics/meshing/volume_mesh.hpp), in the
/// order of order_by_place. They are kept in `cache_folder` under the surface and the fineness, because 10,000 of them
/// take a second or two. Troubles of the cache are added to `notes`. Throws InputError, beginning with `file`, where
/// the surface encloses no volume, where no tetrahedra come about, or where the plugin is not installed.
TetMesh filled_surface(const TriangleMesh& surface, const VolumeFineness& fineness, const std::string& file,
                       std::vector<std::string>& notes,
                       const std::filesystem::path& cache_folder = default_cache_folder());

/// What the cache keeps of a mesh, and back. Nothing where the bytes have another layout, an index or coordinate is out
/// of range, or a tetrahedron has no positive volume, so that the mesh may be used without a further look.
std::string to_bytes(const TetMesh& mesh);
std::optional<TetMesh> tets_from_bytes(std::string_view bytes);

}  // namespace tactor
