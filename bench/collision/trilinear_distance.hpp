// A grid of distances with trilinear interpolation and nothing else.
#pragma once

#include <array>
#include <vector>

#include "nodes/physics/geometry/signed_distance.hpp"
#include "nodes/physics/mesh/mesh.hpp"

namespace tactor::bench {

/// Distances at the corners of cubic cells, as float: exact within 4 mm of the surface, further away a bound that is
/// too near. Between the corners they are interpolated, and the gradient is that of the interpolation.
class TrilinearDistance final : public SignedDistance {
 public:
  /// `mesh`: of a solid. `cells`: along the longest side of its box.
  TrilinearDistance(const TriangleMesh& mesh, int cells);

  [[nodiscard]] Nearest nearest(const Vec3& x, int hint = -1) const override;
  void lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const override;
  [[nodiscard]] Eigen::Matrix3d hessian(const Nearest& nearest, const Vec3& x) const override;

 private:
  [[nodiscard]] std::size_t place(std::size_t i, std::size_t j, std::size_t k) const;

  double cell_ = 0;  // m
  Vec3 origin_;      // m
  std::array<int, 3> corners_{};
  std::vector<float> values_;  // m
};

}  // namespace tactor::bench
