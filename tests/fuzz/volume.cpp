// Files of tetrahedra: the first byte chooses the reader. What becomes a mesh has positive volumes, a closed boundary
// and no index out of range.
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"
#include "nodes/physics/mesh/tet_quality.hpp"
#include "nodes/physics/mesh/volume_formats.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  if (size == 0) return 0;
  const VolumeFormat format = data[0] % 2 == 0 ? VolumeFormat::msh : VolumeFormat::vtu;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    VolumeSoup soup = read_volume("volume", format, bytes);
    for (const Vec3& p : soup.nodes) fuzz::require(is_usable(p), "nodes are finite");
    const auto in_range = [](int i, std::size_t count) { return i >= 0 && static_cast<std::size_t>(i) < count; };
    for (const auto& tet : soup.tets) {
      for (const int i : tet) fuzz::require(in_range(i, soup.nodes.size()), "indices of a file are in range");
    }
    const TetMesh mesh = make_volume(soup, "volume");
    fuzz::require(!mesh.tets.empty(), "a mesh has tetrahedra");
    for (const auto& tet : mesh.tets) {
      for (const int i : tet) fuzz::require(in_range(i, mesh.nodes.size()), "indices are in range");
      fuzz::require(volume_of(corners_of(mesh, tet)) > 0, "volumes are positive");
    }
    std::map<std::pair<int, int>, int> edges;
    for (const auto& face : mesh.faces) {
      for (std::size_t k = 0; k < 3; ++k) {
        ++edges[{face[k], face[(k + 1) % 3]}];
        --edges[{face[(k + 1) % 3], face[k]}];
      }
    }
    for (const auto& [edge, surplus] : edges) fuzz::require(surplus == 0, "the boundary is closed");
    for (const FaceGroup& group : mesh.groups) {
      for (const auto& face : group.faces) {
        for (const int i : face) fuzz::require(in_range(i, mesh.nodes.size()), "indices of groups are in range");
      }
    }
  } catch (const InputError& error) {
    fuzz::require(std::string_view(error.what()).starts_with("volume"), "a refusal names the file");
  }
  return 0;
}
