#include "nodes/physics/mesh/filled_surface.hpp"

#include <algorithm>
#include <cstdint>

#include "framework/core/check.hpp"
#include "framework/core/disk_cache.hpp"
#include "nodes/physics/mesh/byte_lists.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/meshing_plugin.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"
#include "nodes/physics/mesh/tet_quality.hpp"
#include "nodes/physics/mesh/tet_topology.hpp"

namespace tactor {

namespace {

// Of the layout below and of what the plugin makes of a surface.
constexpr std::uint32_t volume_version = 3;

bool is_sound(const TetMesh& mesh) {
  const auto in_range = [&](int i) { return i >= 0 && static_cast<std::size_t>(i) < mesh.nodes.size(); };
  return !mesh.tets.empty() && std::all_of(mesh.nodes.begin(), mesh.nodes.end(), is_usable) &&
         std::all_of(mesh.tets.begin(), mesh.tets.end(), [&](const auto& tet) {
           return std::all_of(tet.begin(), tet.end(), in_range) && volume_of(corners_of(mesh, tet)) > 0;
         });
}

}  // namespace

std::string to_bytes(const TetMesh& mesh) {
  std::string out;
  put_list(out, mesh.nodes);
  put_list(out, mesh.tets);
  return out;
}

std::optional<TetMesh> tets_from_bytes(std::string_view bytes) {
  TetMesh mesh;
  ByteTaker taker{bytes};
  taker.list(mesh.nodes);
  taker.list(mesh.tets);
  if (!taker.ok || !taker.rest.empty() || !is_sound(mesh)) return std::nullopt;
  const std::size_t nodes = mesh.nodes.size();
  finish_mesh(mesh);
  if (mesh.nodes.size() != nodes || !find_overlap(mesh).empty()) return std::nullopt;
  return mesh;
}

TetMesh filled_surface(const TriangleMesh& surface, const VolumeFineness& fineness, const std::string& file,
                       std::vector<std::string>& notes, const std::filesystem::path& cache_folder) {
  const double volume = mass_properties(surface).volume;
  if (!(volume > 0)) {
    throw InputError(
        file + ": the surface encloses a volume of " + std::to_string(volume) +
        " m^3; that of a deformable body must be closed, with faces counter-clockwise as seen from outside");
  }
  std::string content;
  put_list(content, surface.vertices);
  put_list(content, surface.faces);
  put_number(content, fineness.edge > 0 ? 0 : fineness.tetrahedra);
  put_list(content, std::vector<double>{fineness.edge});
  const DiskCache cache("tetrahedra", volume_version, cache_folder);
  const std::string key = content_key({content});
  DiskCache::Found found = cache.load(key);
  if (!found.note.empty()) notes.push_back(std::move(found.note));
  if (found.bytes) {
    if (std::optional<TetMesh> cached = tets_from_bytes(found.bytes->view())) return std::move(*cached);
    notes.push_back(cache.file(key).string() + ": the cached file holds no tetrahedra; computed again and replaced");
  }
  TetMesh mesh = load_meshing_plugin("the tetrahedra of " + file).volume_mesh(surface, fineness, file);
  order_by_place(mesh);
  if (!is_sound(mesh)) {
    throw InputError(file +
                     ": the mesher made a tetrahedron without volume; ask for another number of tetrahedra, or repair "
                     "the surface where it is thinnest");
  }
  finish_mesh(mesh);
  std::string note = cache.store(key, to_bytes(mesh));
  if (!note.empty()) notes.push_back(std::move(note));
  return mesh;
}

}  // namespace tactor
