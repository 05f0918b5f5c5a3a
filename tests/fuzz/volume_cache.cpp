// Cache entries of tetrahedra. What is believed has no index or coordinate out of range, and positive volumes.
#include <cstddef>
#include <cstdint>
#include <string>

#include "nodes/physics/mesh/filled_surface.hpp"
#include "nodes/physics/mesh/tet_quality.hpp"
#include "patched.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const std::string good =
      to_bytes(TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}, {{0, 1, 2, 3}, {0, 2, 1, 4}}, {}, {}});
  const std::string bytes = fuzz::patched(good, data, size);
  const auto mesh = tets_from_bytes(bytes);
  if (!mesh) return 0;
  fuzz::require(to_bytes(*mesh) == bytes, "a mesh is kept as it was");
  fuzz::require(quality_of(*mesh).volume > 0, "the volume is positive");
  return 0;
}
