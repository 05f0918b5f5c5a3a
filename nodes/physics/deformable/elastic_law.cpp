#include "nodes/physics/deformable/elastic_law.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/deformable/cofactors.hpp"
#include "nodes/physics/deformable/nearest_rotation.hpp"

namespace tactor {

namespace {

/// Of two singular values that nearly cancel.
constexpr double smallest_sum = 1e-6;

}  // namespace

Lame lame(double young, double poisson) {
  return {young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))};
}

CorotationalLaw::CorotationalLaw(const Lame& lame) : mu(lame.mu), lambda(lame.lambda) {}

double CorotationalLaw::energy(const Eigen::Matrix3d& F) const {
  Eigen::Matrix3d R;
  nearest_rotation(F, R);
  const double trace = R.cwiseProduct(F).sum() - 3;
  return mu * (F - R).squaredNorm() + 0.5 * lambda * trace * trace;
}

void CorotationalLaw::stress(const Eigen::Matrix3d& F, Eigen::Matrix3d& P) const {
  Eigen::Matrix3d R;
  rotated_stress(F, P, R);
}

void CorotationalLaw::rotated_stress(const Eigen::Matrix3d& F, Eigen::Matrix3d& P, Eigen::Matrix3d& R) const {
  nearest_rotation(F, R);
  P = 2 * mu * (F - R) + lambda * (R.cwiseProduct(F).sum() - 3) * R;
}

void CorotationalLaw::tangent(const Eigen::Matrix3d& F, Eigen::Matrix3d& P, SignedSvd& svd,
                              PrincipalTangent& tangent) const {
  signed_svd(F, svd);
  const Eigen::Matrix3d R = svd.U * svd.V.transpose();
  const double pressure = lambda * (svd.s[0] + svd.s[1] + svd.s[2] - 3);
  P = 2 * mu * (F - R) + pressure * R;
  tangent.A.setConstant(lambda);
  tangent.A.diagonal().setConstant(lambda + 2 * mu);
  tangent.flip.setConstant(2 * mu);
  for (int k = 0; k < 3; ++k) {
    const double sum = svd.s[(k + 1) % 3] + svd.s[(k + 2) % 3];
    tangent.twist[k] = 2 * mu + (2 * pressure - 4 * mu) / std::max(sum, smallest_sum);
  }
}

NeoHookeanLaw::NeoHookeanLaw(const Lame& lame)
    : mu(4.0 / 3 * lame.mu), lambda(lame.lambda + 5.0 / 6 * lame.mu), a(1 + 0.75 * mu / lambda) {}

double NeoHookeanLaw::energy(const Eigen::Matrix3d& F) const {
  Eigen::Matrix3d C;
  cofactors(F, C);
  const double J = determinant(F, C);
  const double more = F.squaredNorm() - 3;
  return 0.5 * mu * (more - std::log1p(0.25 * more)) + 0.5 * lambda * (J - 1) * (J + 1 - 2 * a);
}

void NeoHookeanLaw::stress(const Eigen::Matrix3d& F, Eigen::Matrix3d& P) const {
  Eigen::Matrix3d C;
  cofactors(F, C);
  const double J = determinant(F, C);
  P = mu * (1 - 1 / (F.squaredNorm() + 1)) * F + lambda * (J - a) * C;
}

void NeoHookeanLaw::tangent(const Eigen::Matrix3d& F, Eigen::Matrix3d& P, SignedSvd& svd,
                            PrincipalTangent& tangent) const {
  stress(F, P);
  signed_svd(F, svd);
  const Eigen::Vector3d& s = svd.s;
  const double more = 1 / (s.squaredNorm() + 1);
  const double shear = mu * (1 - more);
  const double bulk = lambda * (s[0] * s[1] * s[2] - a);
  const double curve = 2 * mu * more * more;
  const Eigen::Vector3d area(s[1] * s[2], s[0] * s[2], s[0] * s[1]);
  for (int i = 0; i < 3; ++i) {
    tangent.A(i, i) = shear + curve * s[i] * s[i] + lambda * area[i] * area[i];
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    tangent.A(j, k) = tangent.A(k, j) = curve * s[j] * s[k] + lambda * area[j] * area[k] + bulk * s[i];
    tangent.twist[i] = shear + bulk * s[i];
    tangent.flip[i] = shear - bulk * s[i];
  }
}

void project(PrincipalTangent& tangent) {
  for (int k = 0; k < 3; ++k) {
    tangent.twist[k] = std::max(tangent.twist[k], 0.0);
    tangent.flip[k] = std::max(tangent.flip[k], 0.0);
  }
  const Eigen::Matrix3d& A = tangent.A;
  // Sylvester: positive where all leading minors are.
  const double minor = A(0, 0) * A(1, 1) - A(0, 1) * A(0, 1);
  const double det =
      A(2, 2) * minor - A(0, 0) * A(1, 2) * A(1, 2) - A(1, 1) * A(0, 2) * A(0, 2) + 2 * A(0, 1) * A(0, 2) * A(1, 2);
  if (A(0, 0) > 0 && minor > 0 && det > 0) return;
  Eigen::Matrix3d V;
  Eigen::Vector3d d;
  symmetric_eigen(A, V, d);
  tangent.A = V * d.cwiseMax(0.0).asDiagonal() * V.transpose();
}

}  // namespace tactor
