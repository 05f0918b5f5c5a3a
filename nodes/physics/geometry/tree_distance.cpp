#include "nodes/physics/geometry/tree_distance.hpp"

namespace tactor {

TreeDistance::TreeDistance(const TriangleMesh& mesh) : surface_(mesh), tree_(surface_) {}

Nearest TreeDistance::nearest(const Vec3& x, int hint) const {
  return surface_.signed_distance(tree_.nearest(surface_, x, hint), x);
}

Eigen::Matrix3d TreeDistance::hessian(const Nearest& nearest, const Vec3& /*x*/) const {
  return surface_.hessian(nearest);
}

}  // namespace tactor
