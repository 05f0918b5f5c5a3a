// Cache entries of cells. Queries of what is believed end, read nothing else, and name a face that is there.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "nodes/physics/geometry/cell_cache.hpp"
#include "patched.hpp"
#include "require.hpp"

namespace {

using namespace tactor;

/// A tetrahedron whose faces are cut so often that its tree has two levels.
TriangleMesh cut_tetrahedron() {
  TriangleMesh mesh{{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  for (int cuts = 0; cuts < 2; ++cuts) {
    std::vector<std::array<int, 3>> faces;
    for (const auto& [a, b, c] : mesh.faces) {
      const auto at = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
      const int middle = static_cast<int>(mesh.vertices.size());
      mesh.vertices.push_back((at(a) + at(b) + at(c)) / 3.0);
      faces.insert(faces.end(), {{a, b, middle}, {b, c, middle}, {c, a, middle}});
    }
    mesh.faces = faces;
  }
  return mesh;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string good = to_bytes(build_cells(cut_tetrahedron(), {.resolution = 8, .band = 0.002}));
  std::optional<CellData> cells = cells_from_bytes(fuzz::patched(good, data, size));
  if (!cells) return 0;
  const CellDistance distance(std::move(*cells));
  const CellData& kept = distance.data();
  for (int i = 0; i < 64; ++i) {
    // Inside the grid, at its rim and beyond it.
    Vec3 x;
    for (int axis = 0; axis < 3; ++axis) {
      const double share = (i >> 2 * axis & 3) * 0.4 - 0.1;
      x[axis] = kept.low[axis] + share * 8 * kept.edge * kept.blocks[static_cast<std::size_t>(axis)];
    }
    const Nearest nearest = distance.nearest(x);
    fuzz::require(nearest.face >= 0 && nearest.face < kept.surface.size(), "the nearest face is one of the solid's");
    static_cast<void>(distance.hessian(nearest, x));
    Points8 points;
    points.x.fill(static_cast<float>(x.x));
    points.y.fill(static_cast<float>(x.y));
    points.z.fill(static_cast<float>(x.z));
    std::array<float, 8> bound{};
    distance.lower_bounds(points, 0xff, bound);
  }
  return 0;
}
