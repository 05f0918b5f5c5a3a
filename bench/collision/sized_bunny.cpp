#include "bench/collision/sized_bunny.hpp"

#include <CGAL/subdivision_method_3.h>

#include "framework/core/input_file.hpp"
#include "meshes/bunny_size.hpp"
#include "meshes/decimate.hpp"
#include "nodes/scene/mesh_formats.hpp"
#include "nodes/scene/mesh_repair.hpp"
#include "nodes/scene/surface.hpp"

namespace tactor::bench {

std::vector<TriangleMesh> sized_bunnies(const std::filesystem::path& source, const std::vector<std::size_t>& sizes) {
  constexpr std::uint64_t most_bytes = std::uint64_t{100} << 20U;
  const std::string name = source.string();
  MeshReport report;
  const TriangleMesh original = make_solid(read_off(name, read_input_file(source, most_bytes)), name, report);
  std::vector<Point> points;
  for (const Vec3& v : original.vertices) points.emplace_back(v.x, v.y, v.z);
  std::vector<std::vector<std::size_t>> triangles;
  for (const auto& f : original.faces) triangles.push_back({f.begin(), f.end()});
  std::vector<TriangleMesh> meshes;
  for (const std::size_t faces : sizes) {
    if (faces < original.faces.size()) {
      meshes.push_back(decimate(original, faces, name));
    } else {
      Surface surface = surface_of(points, triangles);
      while (surface.number_of_faces() < faces) CGAL::Subdivision_method_3::Loop_subdivision(surface);
      surface.collect_garbage();
      meshes.push_back(make_solid(soup_of(surface), name + " with " + std::to_string(faces) + " faces", report));
    }
    bring_to_metres(meshes.back());
  }
  return meshes;
}

}  // namespace tactor::bench
