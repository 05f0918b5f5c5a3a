// Mesh files of every format: the first byte chooses the reader. What is read has finite points and indices in range.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/mesh_formats.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  if (size == 0) return 0;
  constexpr std::array formats{MeshFormat::off, MeshFormat::obj, MeshFormat::stl, MeshFormat::ply};
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    static_cast<void>(mesh_format("mesh", bytes));
  } catch (const InputError&) {
    // The name must tell then.
  }
  try {
    const PolygonSoup soup = read_mesh("mesh", formats[data[0] % formats.size()], bytes);
    for (const Vec3& point : soup.points) fuzz::require(is_usable(point), "points are finite");
    for (const auto& polygon : soup.polygons) {
      fuzz::require(polygon.size() >= 3, "polygons have three corners or more");
      for (const std::size_t i : polygon) fuzz::require(i < soup.points.size(), "indices are in range");
    }
  } catch (const InputError& error) {
    fuzz::require(std::string_view(error.what()).starts_with("mesh"), "a refusal names the file");
  }
  return 0;
}
