#include "bench/collision/sized_bunny.hpp"

#include <CGAL/subdivision_method_3.h>

#include "meshes/bunny_size.hpp"
#include "meshes/decimate.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/make_solid.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor::bench {

std::vector<TriangleMesh> sized_bunnies(const std::filesystem::path& source, const std::vector<std::size_t>& sizes) {
  const std::string name = source.string();
  const TriangleMesh original = load_solid(source).mesh;
  std::vector<TriangleMesh> meshes;
  for (const std::size_t faces : sizes) {
    if (faces < original.faces.size()) {
      meshes.push_back(decimate(original, faces, name));
    } else {
      SurfaceMesh surface = surface_of(original);
      while (surface.number_of_faces() < faces) CGAL::Subdivision_method_3::Loop_subdivision(surface);
      surface.collect_garbage();
      MeshReport report;
      meshes.push_back(make_solid(soup_of(surface), name + " with " + std::to_string(faces) + " faces", report));
    }
    bring_to_metres(meshes.back());
  }
  return meshes;
}

}  // namespace tactor::bench
