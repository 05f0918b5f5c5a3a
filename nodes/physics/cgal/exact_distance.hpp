// The signed distance of a point to a closed triangle mesh, by a search of all faces.
#pragma once

#include <memory>

#include "nodes/physics/geometry/signed_distance.hpp"
#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// Exact distance by CGAL's AABB tree.
class ExactDistance final : public SignedDistance {
 public:
  /// `mesh`: of a solid, as load_solid returns it.
  explicit ExactDistance(const TriangleMesh& mesh);
  ~ExactDistance() override;
  ExactDistance(ExactDistance&&) noexcept;
  ExactDistance& operator=(ExactDistance&&) noexcept;

  [[nodiscard]] Nearest nearest(const Vec3& x, int hint = -1) const override;
  [[nodiscard]] Eigen::Matrix3d hessian(const Nearest& nearest, const Vec3& x) const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tactor
