#include "nodes/physics/geometry/cell_cache.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace tactor {

namespace {

constexpr std::uint32_t cell_version = 3;

/// Calls `use` with every single value of the data, then with every array.
template <class Data, class Use>
void for_each_part(Data& data, const Use& use) {
  use(data.box_low);
  use(data.box_high);
  use(data.slack);
  use(data.low);
  use(data.edge);
  use(data.blocks);
  use(data.tree.origin);
  use(data.tree.reach);
  use(data.surface.corners);
  use(data.surface.normals);
  use(data.tree.nodes);
  use(data.tree.records);
  use(data.block);
  use(data.cells);
  use(data.palette);
  use(data.batches);
  use(data.batch_bound);
}

template <class T>
constexpr bool is_vector = false;
template <class T, class A>
constexpr bool is_vector<std::vector<T, A>> = true;

template <class T, class A>
std::string_view bytes_of(const std::vector<T, A>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// The tree ends, no search of it overruns its stack, and every record and face that it names is there.
bool is_in_range(const FaceTree& tree, std::size_t faces) {
  const std::size_t records = tree.records.size();
  if (tree.nodes.empty() || records < 9 || records > std::numeric_limits<std::int32_t>::max()) return false;
  if (tree.nodes.size() > std::numeric_limits<std::int32_t>::max()) return false;
  const auto is_face = [&](std::int32_t face) { return face >= -1 && face < static_cast<std::int64_t>(faces); };
  if (!std::all_of(tree.records.begin(), tree.records.end(), [&](const FaceRecord& r) { return is_face(r.face); })) {
    return false;
  }
  // A search starts from the first record; the last fills up.
  if (tree.records.front().face < 0 || tree.records.back().face >= 0) return false;
  std::vector<unsigned char> depth(tree.nodes.size(), 0);
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    // Children come after their parent; a node that none before names is out of reach.
    if (n > 0 && depth[n] == 0) return false;
    for (const std::int32_t child : tree.nodes[n].child) {
      if (child == FaceTree::no_child) continue;
      if (child < 0) {
        // Eight records, none of them the one that fills up lists.
        if (static_cast<std::size_t>(~child) + 8 > records - 1) return false;
        continue;
      }
      const auto c = static_cast<std::size_t>(child);
      if (c <= n || c >= tree.nodes.size() || depth[c] != 0) return false;
      depth[c] = static_cast<unsigned char>(depth[n] + 1);
      if (depth[c] >= FaceTree::most_levels) return false;
    }
  }
  return true;
}

/// What a block of cells names is there, and each list begins with a face, so that a search of it finds one.
bool is_in_range(const CellData& data, const CellBlock& block) {
  if (block.cells == -1) return true;
  if (block.cells < 0 || static_cast<std::size_t>(block.cells) >= data.cells.size() / 512) return false;
  const Cell* const cells = &data.cells[512 * static_cast<std::size_t>(block.cells)];
  for (std::size_t i = 0; i < 512; ++i) {
    const std::size_t first = cells[i].list >> 4, count = cells[i].list & 15;
    if (count == 0) continue;
    if (first + count > data.batches.size()) return false;
    std::size_t last = 0;
    for (std::size_t j = first; j < first + count; ++j) {
      for (const std::uint16_t place : data.batches[j]) last = std::max<std::size_t>(last, place);
    }
    if (block.palette + last >= data.palette.size()) return false;
    if (data.tree.records[data.palette[block.palette + data.batches[first][0]]].face < 0) return false;
  }
  return true;
}

/// Every index is in range and every number by which places are computed is finite: no query reads beyond the data,
/// whatever the other numbers say.
bool is_in_range(const CellData& data) {
  const auto is_usable = [](double value) { return std::abs(value) <= 1e30; };
  const auto is_point = [&](const Vec3& v) { return is_usable(v.x) && is_usable(v.y) && is_usable(v.z); };
  const std::size_t faces = data.surface.corners.size();
  if (faces == 0 || faces > std::numeric_limits<std::int32_t>::max() || data.surface.normals.size() != faces) {
    return false;
  }
  if (!is_point(data.box_low) || !is_point(data.box_high) || !is_point(data.low) || !is_point(data.tree.origin) ||
      !is_usable(data.slack) || !is_usable(data.tree.reach) || !is_usable(data.edge) || !(data.edge >= 1e-30)) {
    return false;
  }
  std::size_t blocks = 1;
  for (const std::int32_t n : data.blocks) {
    // The most of a mesh is far less; to this number floats tell every cell from the next.
    if (n < 1 || n > 1 << 18 || blocks > data.block.size()) return false;
    blocks *= static_cast<std::size_t>(n);
  }
  if (blocks != data.block.size() || data.cells.size() % 512 != 0) return false;
  if (data.batch_bound.size() != data.batches.size() || !is_in_range(data.tree, faces)) return false;
  const std::size_t records = data.tree.records.size();
  return std::all_of(data.palette.begin(), data.palette.end(), [&](std::uint32_t r) { return r < records; }) &&
         std::all_of(data.block.begin(), data.block.end(), [&](const CellBlock& b) { return is_in_range(data, b); });
}

/// Faces are named by their places in the mesh, so they must be the same ones.
bool has_faces_of(const Surface& surface, const TriangleMesh& mesh) {
  const auto is_same = [&](const std::array<Vec3, 3>& corners, const std::array<int, 3>& face) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!(corners[i] == mesh.vertices[static_cast<std::size_t>(face[i])])) return false;
    }
    return true;
  };
  return std::equal(surface.corners.begin(), surface.corners.end(), mesh.faces.begin(), mesh.faces.end(), is_same);
}

}  // namespace

DiskCache cell_cache(std::filesystem::path folder) {
  return {"cells", cell_version, std::move(folder)};
}

std::string cell_key(const TriangleMesh& mesh, const CellOptions& options) {
  const std::string_view resolution(reinterpret_cast<const char*>(&options.resolution), sizeof options.resolution);
  const std::string_view band(reinterpret_cast<const char*>(&options.band), sizeof options.band);
  return content_key({bytes_of(mesh.vertices), bytes_of(mesh.faces), resolution, band});
}

std::string to_bytes(const CellData& data) {
  std::string bytes;
  for_each_part(data, [&](const auto& part) {
    using Part = std::remove_cvref_t<decltype(part)>;
    if constexpr (is_vector<Part>) {
      static_assert(std::is_trivially_copyable_v<typename Part::value_type>);
      const std::uint64_t count = part.size();
      bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
      bytes.append(bytes_of(part));
    } else {
      static_assert(std::is_trivially_copyable_v<Part>);
      bytes.append(reinterpret_cast<const char*>(&part), sizeof part);
    }
  });
  return bytes;
}

std::optional<CellData> cells_from_bytes(std::string_view bytes) {
  CellData data;
  bool whole = true;
  const auto take = [&](void* to, std::size_t size) {
    whole = whole && size <= bytes.size();
    if (!whole || size == 0) return;
    std::memcpy(to, bytes.data(), size);
    bytes.remove_prefix(size);
  };
  for_each_part(data, [&](auto& part) {
    using Part = std::remove_cvref_t<decltype(part)>;
    if constexpr (is_vector<Part>) {
      std::uint64_t count = 0;
      take(&count, sizeof count);
      whole = whole && count <= bytes.size() / sizeof(typename Part::value_type);
      if (!whole) return;
      part.resize(count);
      take(part.data(), count * sizeof(typename Part::value_type));
    } else {
      take(&part, sizeof part);
    }
  });
  if (!whole || !bytes.empty() || !is_in_range(data)) return std::nullopt;
  return data;
}

CellDistance cached_cell_distance(const TriangleMesh& mesh, const CellOptions& options, const DiskCache& cache,
                                  std::vector<std::string>* notes) {
  const auto tell = [&](const std::string& note) {
    if (notes != nullptr && !note.empty()) notes->push_back(note);
  };
  const std::string key = cell_key(mesh, options);
  const DiskCache::Found found = cache.load(key);
  tell(found.note);
  if (found.bytes) {
    std::optional<CellData> data = cells_from_bytes(found.bytes->view());
    if (data && has_faces_of(data->surface, mesh)) return CellDistance(std::move(*data));
    tell(cache.file(key).string() + ": the cached file holds no cells of this mesh; computed again and replaced");
  }
  CellDistance distance(mesh, options);
  tell(cache.store(key, to_bytes(distance.data())));
  return distance;
}

}  // namespace tactor
