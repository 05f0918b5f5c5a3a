#include "bench/collision/sized_bunny.hpp"

#include <algorithm>
#include <fstream>

#include <CGAL/IO/OFF.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/subdivision_method_3.h>

#include "framework/core/check.hpp"
#include "meshes/bunny_size.hpp"
#include "meshes/decimate.hpp"

namespace tactor::bench {

std::vector<TriangleMesh> sized_bunnies(const std::filesystem::path& source, const std::vector<std::size_t>& sizes) {
  Surface original;
  std::ifstream in(source);
  if (!in || !CGAL::IO::read_OFF(in, original)) {
    throw InputError(source.string() + ": cannot be read as OFF; build the target tactor_meshes first");
  }
  std::vector<TriangleMesh> meshes;
  for (const std::size_t faces : sizes) {
    Surface surface = original;
    if (faces < original.number_of_faces()) {
      meshes.push_back(decimate(surface, faces, source.string()));
    } else {
      while (surface.number_of_faces() < faces) CGAL::Subdivision_method_3::Loop_subdivision(surface);
      meshes.push_back(indexed(surface));
    }
    if (!CGAL::is_closed(surface) || CGAL::Polygon_mesh_processing::does_self_intersect(surface)) {
      throw RunError(source.string() + ": with " + std::to_string(meshes.back().faces.size()) +
                     " faces it is open or cuts itself");
    }
    bring_to_metres(meshes.back());
  }
  return meshes;
}

}  // namespace tactor::bench
