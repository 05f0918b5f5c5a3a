#include "nodes/physics/deformable/signed_svd.hpp"

#include <cmath>

namespace tactor {

namespace {

/// One Jacobi rotation in the plane of p and q of the symmetric matrix with diagonal d and the entry `pq` off it; `rp`
/// and `rq` are the entries of p and q with the third axis. An entry whose square is not above `tiny` stays.
inline void rotate_plane(double& pp, double& qq, double& pq, double& rp, double& rq, double* vp, double* vq,
                         double tiny) {
  if (pq * pq <= tiny) return;
  const double half = 0.5 * (qq - pp);
  // Tangent, cosine and sine of the smaller angle. The divisions do not wait for each other.
  const double sum = half + std::copysign(std::sqrt(half * half + pq * pq), half);
  const double unit = 1 / std::sqrt(sum * sum + pq * pq);
  const double t = pq / sum;
  const double c = std::abs(sum) * unit;
  const double s = std::copysign(1.0, sum) * pq * unit;
  pp -= t * pq;
  qq += t * pq;
  pq = 0;
  const double old = rp;
  rp = c * old - s * rq;
  rq = s * old + c * rq;
  for (int k = 0; k < 3; ++k) {
    const double v = vp[k];
    vp[k] = c * v - s * vq[k];
    vq[k] = s * v + c * vq[k];
  }
}

constexpr int most_sweeps = 12;

/// A vector across the unit vector `a`.
Eigen::Vector3d across(const Eigen::Vector3d& a) {
  const double x = std::abs(a.x()), y = std::abs(a.y()), z = std::abs(a.z());
  const Eigen::Vector3d axis = x <= y && x <= z ? Eigen::Vector3d::UnitX()
                               : y <= z         ? Eigen::Vector3d::UnitY()
                                                : Eigen::Vector3d::UnitZ();
  return (axis - axis.dot(a) * a).normalized();
}

inline Eigen::Vector3d cross_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

void symmetric_eigen(const Eigen::Matrix3d& A, Eigen::Matrix3d& V, Eigen::Vector3d& d) {
  V.setIdentity();
  d = A.diagonal();
  double a01 = A(0, 1), a02 = A(0, 2), a12 = A(1, 2);
  double* const v = V.data();
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    const double off = a01 * a01 + a02 * a02 + a12 * a12;
    const double scale = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    const double tiny = 1e-33 * scale;
    if (!(off > tiny)) return;
    rotate_plane(d[0], d[1], a01, a02, a12, v, v + 3, tiny);
    rotate_plane(d[0], d[2], a02, a01, a12, v, v + 6, tiny);
    rotate_plane(d[1], d[2], a12, a01, a02, v + 3, v + 6, tiny);
  }
}

void signed_svd(const Eigen::Matrix3d& F, SignedSvd& svd) {
  Eigen::Matrix3d C;
  C(0, 0) = F.col(0).dot(F.col(0));
  C(1, 1) = F.col(1).dot(F.col(1));
  C(2, 2) = F.col(2).dot(F.col(2));
  C(0, 1) = F.col(0).dot(F.col(1));
  C(0, 2) = F.col(0).dot(F.col(2));
  C(1, 2) = F.col(1).dot(F.col(2));
  Eigen::Matrix3d V;
  Eigen::Vector3d d;
  symmetric_eigen(C, V, d);
  // The largest first. A column changes its sign when it is exchanged, so that V stays a rotation.
  const auto exchange = [&](int i, int j) {
    if (d[i] >= d[j]) return;
    std::swap(d[i], d[j]);
    const Eigen::Vector3d column = V.col(i);
    V.col(i) = V.col(j);
    V.col(j) = -column;
  };
  exchange(0, 1);
  exchange(0, 2);
  exchange(1, 2);
  const Eigen::Vector3d b0 = F * V.col(0), b1 = F * V.col(1), b2 = F * V.col(2);
  const double s0 = std::sqrt(b0.dot(b0));
  const Eigen::Vector3d u0 = s0 > 0 ? Eigen::Vector3d(b0 / s0) : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d rest = b1 - u0.dot(b1) * u0;
  const double length = std::sqrt(rest.dot(rest));
  Eigen::Vector3d u1;
  if (length > 1e-14 * s0) {
    u1 = rest / length;
    // Once more: where b1 is much shorter than b0, what was taken off left rounding of b0's size.
    if (length < 1e-3 * s0) u1 = (u1 - u0.dot(u1) * u0).normalized();
  } else {
    u1 = across(u0);
  }
  const Eigen::Vector3d u2 = cross_of(u0, u1);
  svd.U.col(0) = u0;
  svd.U.col(1) = u1;
  svd.U.col(2) = u2;
  svd.V = V;
  svd.s = {s0, u1.dot(b1), u2.dot(b2)};
}

}  // namespace tactor
