// The signed distance of a point to a closed triangle mesh, by a search of all faces that needs no preparation.
#pragma once

#include "nodes/physics/geometry/face_tree.hpp"

namespace tactor {

/// The distance of CellDistance, to the bit, without its cells.
class TreeDistance final : public SignedDistance {
 public:
  /// `mesh`: of a solid, as load_solid returns it.
  explicit TreeDistance(const TriangleMesh& mesh);

  [[nodiscard]] Nearest nearest(const Vec3& x, int hint = -1) const override;
  [[nodiscard]] Eigen::Matrix3d hessian(const Nearest& nearest, const Vec3& x) const override;

 private:
  Surface surface_;
  FaceTree tree_;
};

}  // namespace tactor
