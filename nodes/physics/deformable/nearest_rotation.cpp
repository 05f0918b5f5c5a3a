#include "nodes/physics/deformable/nearest_rotation.hpp"

#include "nodes/physics/deformable/cofactors.hpp"
#include "nodes/physics/deformable/signed_svd.hpp"

namespace tactor {

namespace {

constexpr double least_volume = 0.05;  // det F, below which the iteration would be slow
constexpr int most_iterations = 8;
constexpr double last_change = 1e-16;  // |dR|^2; the next one would be its square

/// R <- (R + R^-T) / 2 until it stands. False where it does not.
bool by_newton(Eigen::Matrix3d& R) {
  Eigen::Matrix3d C;
  for (int i = 0; i < most_iterations; ++i) {
    cofactors(R, C);
    const double det = determinant(R, C);
    if (!(det > least_volume)) return false;
    C = (0.5 / det) * C - 0.5 * R;
    R += C;
    if (C.squaredNorm() <= last_change) return true;
  }
  return false;
}

}  // namespace

void nearest_rotation(const Eigen::Matrix3d& F, Eigen::Matrix3d& R) {
  R = F;
  if (by_newton(R)) return;
  SignedSvd svd;
  signed_svd(F, svd);
  R = svd.U * svd.V.transpose();
}

}  // namespace tactor
