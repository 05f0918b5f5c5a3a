#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

Vec3 doubled_area_normal(const TriangleMesh& mesh, const std::array<int, 3>& face) {
  const auto corner = [&](int i) { return mesh.vertices[static_cast<std::size_t>(face[static_cast<std::size_t>(i)])]; };
  return cross(corner(1) - corner(0), corner(2) - corner(0));
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& face : mesh.faces) area += 0.5 * norm(doubled_area_normal(mesh, face));
  return area;
}

}  // namespace tactor
