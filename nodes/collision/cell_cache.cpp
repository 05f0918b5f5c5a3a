#include "nodes/collision/cell_cache.hpp"

#include <cstring>
#include <type_traits>
#include <utility>

namespace tactor {

namespace {

constexpr std::uint32_t cell_version = 2;

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
  if (!whole || !bytes.empty()) return std::nullopt;
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
    if (std::optional<CellData> data = cells_from_bytes(*found.bytes)) return CellDistance(std::move(*data));
    tell(cache.file(key).string() + ": the cached file is of another layout; computed again and replaced");
  }
  CellDistance distance(mesh, options);
  tell(cache.store(key, to_bytes(distance.data())));
  return distance;
}

}  // namespace tactor
