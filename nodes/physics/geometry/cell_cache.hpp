// Cells of meshes kept on disk, because they take seconds to build.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/disk_cache.hpp"
#include "nodes/physics/geometry/cell_distance.hpp"

namespace tactor {

/// The cache of cells; its version counts the changes of CellData and of what build_cells makes.
DiskCache cell_cache(std::filesystem::path folder = default_cache_folder());

/// The entry of a mesh: named by the bytes of its corners and faces, and by the options.
std::string cell_key(const TriangleMesh& mesh, const CellOptions& options);

/// The distance of a mesh from its cells in the cache, or built and stored there where it holds none. Adds to `notes`,
/// where that is not null, what kept the cache from being used or filled.
CellDistance cached_cell_distance(const TriangleMesh& mesh, const CellOptions& options, const DiskCache& cache,
                                  std::vector<std::string>* notes);

/// All of the data as bytes of this machine, and back. Nothing where the bytes have another layout or where an index or
/// count in them is out of range: queries of what is returned may answer nonsense, but they end and read nothing else.
std::string to_bytes(const CellData& data);
std::optional<CellData> cells_from_bytes(std::string_view bytes);

}  // namespace tactor
