#include "nodes/physics/mesh/mass_properties.hpp"

#include <Eigen/Geometry>

namespace tactor {

namespace {
Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}
}  // namespace

MassProperties mass_properties(const TriangleMesh& mesh) {
  MassProperties result;
  result.inertia.setZero();
  if (mesh.vertices.empty()) return result;
  // Moments about a point of the mesh keep their digits for a mesh far from its origin.
  const Vec3 reference = mesh.vertices.front();
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const auto& face : mesh.faces) {
    Eigen::Matrix3d corners;
    for (int i = 0; i < 3; ++i) {
      corners.col(i) = eigen(mesh.vertices[static_cast<std::size_t>(face[static_cast<std::size_t>(i)])] - reference);
    }
    const double tetrahedron = corners.col(0).dot(corners.col(1).cross(corners.col(2))) / 6.0;
    const Eigen::Vector3d sum = corners.rowwise().sum();
    volume += tetrahedron;
    first += tetrahedron / 4.0 * sum;
    second += tetrahedron / 20.0 * (corners * corners.transpose() + sum * sum.transpose());
  }
  if (volume == 0) return result;
  const Eigen::Vector3d center = first / volume;
  second -= volume * center * center.transpose();
  result.volume = volume;
  result.center = reference + Vec3{center.x(), center.y(), center.z()};
  result.inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  return result;
}

}  // namespace tactor
