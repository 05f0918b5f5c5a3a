#include "nodes/physics/mesh/solid_file.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/core/input_file.hpp"
#include "nodes/physics/mesh/byte_lists.hpp"
#include "nodes/physics/mesh/make_solid.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

// Of the layout below and of what readers and repairs make of a file.
constexpr std::uint32_t cache_version = 2;

std::string read_whole(const fs::path& path) {
  constexpr std::uint64_t most = std::uint64_t{1} << 30U;
  InputFile input = open_input(path);
  if (input.size > most) {
    throw InputError(path.string() + ": the file has " + std::to_string(input.size >> 20U) +
                     " MiB; a mesh file may have 1024, decimate the mesh in a modeller");
  }
  std::string bytes;
  if (!input.file || !input.read(bytes, most)) throw InputError(path.string() + ": " + input.error);
  return bytes;
}

/// Whether every index and number may be used as it is; closed and without cuts is what made the entry.
bool is_in_range(const TriangleMesh& mesh) {
  const auto corner = [&](int i) { return i >= 0 && static_cast<std::size_t>(i) < mesh.vertices.size(); };
  const auto face = [&](const std::array<int, 3>& f) {
    return corner(f[0]) && corner(f[1]) && corner(f[2]) && f[0] != f[1] && f[1] != f[2] && f[2] != f[0];
  };
  return !mesh.faces.empty() && std::all_of(mesh.faces.begin(), mesh.faces.end(), face) &&
         std::all_of(mesh.vertices.begin(), mesh.vertices.end(), is_usable);
}

}  // namespace

std::string to_bytes(const SolidFile& solid) {
  std::string out;
  put_list(out, solid.mesh.vertices);
  put_list(out, solid.mesh.faces);
  for (const std::vector<std::string>* texts : {&solid.report.repairs, &solid.report.warnings}) {
    put_number(out, texts->size());
    for (const std::string& text : *texts) put_list(out, text);
  }
  return out;
}

std::optional<SolidFile> solid_from_bytes(std::string_view bytes) {
  SolidFile solid;
  ByteTaker taker{bytes};
  taker.list(solid.mesh.vertices);
  taker.list(solid.mesh.faces);
  for (std::vector<std::string>* texts : {&solid.report.repairs, &solid.report.warnings}) {
    for (std::uint64_t n = taker.number(); n > 0 && taker.ok; --n) taker.list(texts->emplace_back());
  }
  if (!taker.ok || !taker.rest.empty() || !is_in_range(solid.mesh)) return std::nullopt;
  return solid;
}

namespace {

SolidFile load_within_memory(const fs::path& path, const fs::path& cache_folder) {
  const std::string file = path.string();
  const std::string bytes = read_whole(path);
  const MeshFormat format = mesh_format(file, bytes);
  const DiskCache cache("mesh", cache_version, cache_folder);
  const std::string key =
      content_key({bytes, std::to_string(static_cast<int>(format)), repairs_meshes() ? "repaired" : "as it is"});
  SolidFile solid;
  DiskCache::Found found = cache.load(key);
  if (!found.note.empty()) solid.notes.push_back(std::move(found.note));
  if (found.bytes) {
    if (std::optional<SolidFile> cached = solid_from_bytes(found.bytes->view())) return std::move(*cached);
    solid.notes.push_back(cache.file(key).string() + ": the cached file holds no solid; computed again and replaced");
  }
  try {
    solid.mesh = make_solid(read_mesh(file, format, bytes), file, solid.report);
  } catch (const InputError& error) {
    throw InputError(error.what() + repair_hint(solid.report, file));
  }
  std::string note = cache.store(key, to_bytes(solid));
  if (!note.empty()) solid.notes.push_back(std::move(note));
  return solid;
}

}  // namespace

SolidFile load_solid(const fs::path& path, const fs::path& cache_folder) {
  return within_memory(path, [&] { return load_within_memory(path, cache_folder); });
}

MeshFile read_mesh_file(const fs::path& path) {
  return within_memory(path, [&] {
    const std::string file = path.string();
    const std::string bytes = read_whole(path);
    const MeshFormat format = mesh_format(file, bytes);
    return MeshFile{format, read_mesh(file, format, bytes)};
  });
}

}  // namespace tactor
