#include "nodes/physics/geometry/surface.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

namespace {
Vec3 unit(const Vec3& v) {
  return v / norm(v);
}
}  // namespace

Surface::Surface(const TriangleMesh& mesh) {
  const auto at = [&](int i) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(i)]; };
  struct FaceEdge {
    std::pair<int, int> ends;
    std::size_t face;
    std::size_t i;
  };
  std::vector<FaceEdge> edges;
  std::vector<Vec3> vertices(mesh.vertices.size());
  edges.reserve(3 * mesh.faces.size());
  corners.reserve(mesh.faces.size());
  normals.resize(mesh.faces.size());
  for (std::size_t k = 0; k < mesh.faces.size(); ++k) {
    const auto& f = mesh.faces[k];
    corners.push_back({at(f[0]), at(f[1]), at(f[2])});
    const Vec3 n = normals[k].face = unit(doubled_area_normal(mesh, f));
    for (std::size_t i = 0; i < 3; ++i) {
      const int from = f[i], to = f[(i + 1) % 3], other = f[(i + 2) % 3];
      edges.push_back({std::minmax(from, to), k, i});
      const Vec3 u = unit(at(to) - at(from)), v = unit(at(other) - at(from));
      vertices[static_cast<std::size_t>(from)] += std::acos(std::clamp(dot(u, v), -1.0, 1.0)) * n;
    }
  }
  // The faces beside an edge stand together then, in their order.
  std::stable_sort(edges.begin(), edges.end(), [](const FaceEdge& a, const FaceEdge& b) { return a.ends < b.ends; });
  for (auto first = edges.begin(), last = first; first != edges.end(); first = last) {
    Vec3 sum;
    for (; last != edges.end() && last->ends == first->ends; ++last) sum += normals[last->face].face;
    for (; first != last; ++first) normals[first->face].edge[first->i] = unit(sum);
  }
  for (std::size_t k = 0; k < mesh.faces.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      normals[k].corner[i] = unit(vertices[static_cast<std::size_t>(mesh.faces[k][i])]);
    }
  }
}

Nearest Surface::signed_distance(const NearestFace& nearest, const Vec3& x) const {
  const Normals& of = normals[static_cast<std::size_t>(nearest.face)];
  const OnTriangle& on = nearest.on;
  const Vec3& n = on.feature == Feature::face ? of.face : on.feature == Feature::edge ? of.edge[on.i] : of.corner[on.i];
  const Vec3 away = x - on.p;
  const double length = norm(away);
  const double sign = dot(away, n) < 0 ? -1 : 1;
  // Nearer than rounding to the surface, the difference has no direction.
  const bool on_surface = length < 1e-12;
  return {sign * length, on.p, on_surface ? n : away * (sign / length), nearest.face, on.feature, on.i};
}

Eigen::Matrix3d Surface::hessian(const Nearest& nearest) const {
  if (nearest.feature == Feature::face || std::abs(nearest.distance) < 1e-12) return Eigen::Matrix3d::Zero();
  const auto outer = [](const Vec3& v) {
    const Eigen::Vector3d u(v.x, v.y, v.z);
    return Eigen::Matrix3d(u * u.transpose());
  };
  Eigen::Matrix3d flat = Eigen::Matrix3d::Identity() - outer(nearest.gradient);
  if (nearest.feature == Feature::edge) {
    const auto& corner = corners[static_cast<std::size_t>(nearest.face)];
    flat -= outer(unit(corner[(nearest.of_face + 1U) % 3] - corner[nearest.of_face]));
  }
  return flat / nearest.distance;
}

}  // namespace tactor
