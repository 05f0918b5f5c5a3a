// Singular values of 3x3 matrices, with rotations on both sides.
#pragma once

#include <Eigen/Core>

namespace tactor {

/// F = U diag(s) V^T, where U and V are rotations (determinant 1) and s[0] >= s[1] >= |s[2]|. Where det F < 0, s[2] <
/// 0. So U V^T is the rotation nearest to F, also where F is inverted (Irving, Teran and Fedkiw, SCA 2004).
struct SignedSvd {
  Eigen::Matrix3d U, V;
  Eigen::Vector3d s;
};

/// By Jacobi rotations of F^T F, as in McAdams, Selle, Tamstorf, Teran and Sifakis, University of Wisconsin TR1690
/// (2011). The product differs from F by rounding of its largest entry where s[1] is not small beside s[0], else by
/// s[0] / s[1] times that at most. Any finite F is taken: of rank 2, 1 and 0 too, and with repeated singular values.
void signed_svd(const Eigen::Matrix3d& F, SignedSvd& svd);

/// Diagonalises a symmetric matrix: A = V diag(d) V^T, V a rotation; the values are in no order. `A` is given by its
/// upper triangle.
void symmetric_eigen(const Eigen::Matrix3d& A, Eigen::Matrix3d& V, Eigen::Vector3d& d);

}  // namespace tactor
