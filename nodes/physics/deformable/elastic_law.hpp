// Energy, stress and stiffness of an isotropic material at a point, by its deformation gradient.
#pragma once

#include <Eigen/Core>

#include "nodes/physics/deformable/signed_svd.hpp"

namespace tactor {

/// Lame's parameters in Pa: mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)).
struct Lame {
  double mu = 0, lambda = 0;
};
Lame lame(double young, double poisson);

/// The second derivative of the energy density by F, in the axes of U and V: with D = U^T dF V
///   d^2 psi = sum_ij A_ij D_ii D_jj + sum_{i<j} ((twist_k / 2) (D_ij - D_ji)^2 + (flip_k / 2) (D_ij + D_ji)^2), k the
///   third axis.
/// Eigenvalues of the whole are those of A and the six others (Smith, De Goes and Kim, TOG 2019):
///   twist_k = (psi_i + psi_j) / (s_i + s_j),  flip_k = (psi_i - psi_j) / (s_i - s_j).  Pa.
struct PrincipalTangent {
  Eigen::Matrix3d A;
  Eigen::Vector3d twist, flip;
};

/// psi = mu |F - R|^2 + lambda/2 tr(R^T F - I)^2 with R the rotation nearest to F; its stress is that of linear
/// elasticity in the frame that R turns. In singular values: mu sum (s_i - 1)^2 + lambda/2 (sum s_i - 3)^2.
struct CorotationalLaw {
  double mu, lambda;

  explicit CorotationalLaw(const Lame& lame);
  /// J/m^3.
  [[nodiscard]] double energy(const Eigen::Matrix3d& F) const;
  /// Pa, d psi / d F (first Piola-Kirchhoff).
  void stress(const Eigen::Matrix3d& F, Eigen::Matrix3d& P) const;
  /// And the rotation R.
  void rotated_stress(const Eigen::Matrix3d& F, Eigen::Matrix3d& P, Eigen::Matrix3d& R) const;
  /// The stress and the tangent. Where two singular values cancel (an inverted element), twist has a pole; it is
  /// bounded there.
  void tangent(const Eigen::Matrix3d& F, Eigen::Matrix3d& P, SignedSvd& svd, PrincipalTangent& tangent) const;
};

/// Stable neo-Hookean (Smith, De Goes and Kim, TOG 2018):
///   psi = mu/2 (|F|^2 - 3) + lambda/2 (J - a)^2 - mu/2 log(|F|^2 + 1) - psi(I), a = 1 + 3 mu / (4 lambda), J = det F,
/// with mu = 4/3 of Lame's mu and lambda = Lame's lambda + 5/6 of Lame's mu, so that small strain is linear elasticity
/// of the same moduli. Finite for every F, also inverted.
struct NeoHookeanLaw {
  double mu, lambda, a;

  explicit NeoHookeanLaw(const Lame& lame);
  [[nodiscard]] double energy(const Eigen::Matrix3d& F) const;
  void stress(const Eigen::Matrix3d& F, Eigen::Matrix3d& P) const;
  void tangent(const Eigen::Matrix3d& F, Eigen::Matrix3d& P, SignedSvd& svd, PrincipalTangent& tangent) const;
};

/// Takes the negative eigenvalues out of it.
void project(PrincipalTangent& tangent);

}  // namespace tactor
