// Cofactors of 3x3 matrices.
#pragma once

#include <Eigen/Core>

namespace tactor {

/// C = d det F / d F, so F^-T = C / det F.
inline void cofactors(const Eigen::Matrix3d& F, Eigen::Matrix3d& C) {
  C(0, 0) = F(1, 1) * F(2, 2) - F(1, 2) * F(2, 1);
  C(1, 0) = F(0, 2) * F(2, 1) - F(0, 1) * F(2, 2);
  C(2, 0) = F(0, 1) * F(1, 2) - F(0, 2) * F(1, 1);
  C(0, 1) = F(1, 2) * F(2, 0) - F(1, 0) * F(2, 2);
  C(1, 1) = F(0, 0) * F(2, 2) - F(0, 2) * F(2, 0);
  C(2, 1) = F(0, 2) * F(1, 0) - F(0, 0) * F(1, 2);
  C(0, 2) = F(1, 0) * F(2, 1) - F(1, 1) * F(2, 0);
  C(1, 2) = F(0, 1) * F(2, 0) - F(0, 0) * F(2, 1);
  C(2, 2) = F(0, 0) * F(1, 1) - F(0, 1) * F(1, 0);
}

/// det F, with its cofactors known.
inline double determinant(const Eigen::Matrix3d& F, const Eigen::Matrix3d& C) {
  return F(0, 0) * C(0, 0) + F(1, 0) * C(1, 0) + F(2, 0) * C(2, 0);
}

}  // namespace tactor
