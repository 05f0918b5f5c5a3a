// Cache entries of solids. What is believed has no index or coordinate out of range.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "nodes/physics/mesh/solid_file.hpp"
#include "patched.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  static const std::string good =
      to_bytes(SolidFile{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}},
                         {{"1 face was turned round"}, {"it is small", ""}},
                         {}});
  const std::string bytes = fuzz::patched(good, data, size);
  const auto solid = solid_from_bytes(bytes);
  if (!solid) return 0;
  fuzz::require(to_bytes(*solid) == bytes, "a solid is kept as it was");
  fuzz::require(std::isfinite(surface_area(solid->mesh)), "the area is a number");
  return 0;
}
