// Energy, forces and stiffness of all elements: what runs in each step.
#include <algorithm>
#include <type_traits>

#include <Eigen/LU>

#include "framework/core/check.hpp"
#include "nodes/physics/deformable/cofactors.hpp"
#include "nodes/physics/deformable/elastic_law.hpp"
#include "nodes/physics/deformable/elastic_model.hpp"
#include "nodes/physics/deformable/quadrature.hpp"

namespace tactor {

namespace {

using Corners = std::array<Eigen::Vector3d, 4>;
using Gradients = std::array<Eigen::Vector3d, 3>;
/// Stiffness between corners 1, 2, 3: (1,1), (2,1), (2,2), (3,1), (3,2), (3,3). Corner 0 moves against their sum.
using CornerBlocks = std::array<Eigen::Matrix3d, 6>;

/// The product of the three sums of two singular values of F, which is 8 at rest: above, its inverse is well known.
constexpr double least_sums = 1e-3;

template <std::size_t size>
constexpr int points = size == 4 ? 1 : 4;

/// F = sum_c y_c grad L_c^T, by differences to corner 0 because the gradients add up to zero.
inline void deformation(const Corners& y, const Gradients& gradient, Eigen::Matrix3d& F) {
  F = (y[1] - y[0]) * gradient[0].transpose() + (y[2] - y[0]) * gradient[1].transpose() +
      (y[3] - y[0]) * gradient[2].transpose();
}

/// The force of the stress P on the corners.
inline void corner_forces(const Eigen::Matrix3d& P, const Gradients& gradient, double weight, Corners& f) {
  const Eigen::Matrix3d Q = -weight * P;
  for (std::size_t c = 0; c < 3; ++c) f[c + 1] = Q * gradient[c];
  f[0] = -(f[1] + f[2] + f[3]);
}

/// Linear elasticity in the frame R: lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) I with g = R grad L.
inline void warped_blocks(const Eigen::Matrix3d& R, const Gradients& gradient, double mu, double lambda,
                          CornerBlocks& k) {
  Gradients g;
  for (std::size_t c = 0; c < 3; ++c) g[c] = R * gradient[c];
  std::size_t n = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b <= a; ++b, ++n) {
      const double shear = mu * gradient[a].dot(gradient[b]);
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) k[n](i, j) = lambda * (g[a][i] * g[b][j]) + mu * (g[b][i] * g[a][j]);
        k[n](j, j) += shear;
      }
    }
  }
}

/// Adds `share` of what the exact tangent has and the warped one has not: K_e turns with the material, and
///   dR = [w]x R,   (tr(V) I - V) w = 2 axis(skew(dF R^T)),   V = F R^T,
/// so that the blocks are weight / 2 [g_a]x^T H [g_b]x with g = R grad L and
///   H = 2 mu I + 2 (lambda (tr(V) - 3) - 2 mu) (tr(V) I - V)^-1.
/// False, and nothing is added, where two singular values of F nearly cancel.
inline bool add_turning(const Eigen::Matrix3d& F, const Eigen::Matrix3d& R, const CorotationalLaw& law,
                        const Gradients& gradient, double weight, double share, CornerBlocks& k) {
  const Eigen::Matrix3d V = F * R.transpose();
  const double trace = V.trace();
  Eigen::Matrix3d G = -V, cofactor;
  G.diagonal().array() += trace;
  cofactors(G, cofactor);
  const double det = determinant(G, cofactor);
  if (!(det > least_sums)) return false;
  const double factor = 0.5 * share * weight;
  // G is symmetric, so its cofactors are det G times its inverse.
  Eigen::Matrix3d H = (factor * 2 * (law.lambda * (trace - 3) - 2 * law.mu) / det) * cofactor;
  H.diagonal().array() += factor * 2 * law.mu;
  std::array<Eigen::Matrix3d, 3> N, HN;
  for (std::size_t c = 0; c < 3; ++c) {
    const Eigen::Vector3d g = R * gradient[c];
    N[c] << 0, -g[2], g[1], g[2], 0, -g[0], -g[1], g[0], 0;
    HN[c] = H * N[c];
  }
  std::size_t n = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b <= a; ++b, ++n) k[n] += N[a].transpose() * HN[b];
  }
  return true;
}

/// With h = V^T grad L and D = U^T dF V, D_ij = u_i h_j for a displacement u in the axes of U.
inline void principal_blocks(const SignedSvd& svd, const PrincipalTangent& tangent, const Gradients& gradient,
                             double weight, CornerBlocks& k) {
  Gradients h;
  for (std::size_t c = 0; c < 3; ++c) h[c] = svd.V.transpose() * gradient[c];
  const Eigen::Matrix3d A = weight * tangent.A;
  // Of the pair without axis k: half the sum of both eigenvalues, and half the difference.
  const Eigen::Vector3d same = 0.5 * weight * (tangent.flip + tangent.twist);
  const Eigen::Vector3d other = 0.5 * weight * (tangent.flip - tangent.twist);
  std::size_t n = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b <= a; ++b, ++n) {
      const Eigen::Vector3d &p = h[a], &q = h[b];
      const Eigen::Vector3d square(p[0] * q[0], p[1] * q[1], p[2] * q[2]);
      Eigen::Matrix3d m;
      m(0, 0) = A(0, 0) * square[0] + same[2] * square[1] + same[1] * square[2];
      m(1, 1) = A(1, 1) * square[1] + same[2] * square[0] + same[0] * square[2];
      m(2, 2) = A(2, 2) * square[2] + same[1] * square[0] + same[0] * square[1];
      m(0, 1) = A(0, 1) * (p[0] * q[1]) + other[2] * (p[1] * q[0]);
      m(1, 0) = A(0, 1) * (p[1] * q[0]) + other[2] * (p[0] * q[1]);
      m(0, 2) = A(0, 2) * (p[0] * q[2]) + other[1] * (p[2] * q[0]);
      m(2, 0) = A(0, 2) * (p[2] * q[0]) + other[1] * (p[0] * q[2]);
      m(1, 2) = A(1, 2) * (p[1] * q[2]) + other[0] * (p[2] * q[1]);
      m(2, 1) = A(1, 2) * (p[2] * q[1]) + other[0] * (p[1] * q[2]);
      const Eigen::Matrix3d turned = svd.U * m;
      k[n] = turned * svd.U.transpose();
    }
  }
}

/// The mean of a tangent and its projection.
inline void halve(PrincipalTangent& tangent) {
  PrincipalTangent positive = tangent;
  project(positive);
  tangent.A = 0.5 * (tangent.A + positive.A);
  tangent.twist = 0.5 * (tangent.twist + positive.twist);
  tangent.flip = 0.5 * (tangent.flip + positive.flip);
}

/// All ten blocks of four corners: (0,0), (1,0), (1,1), (2,0), ...
inline void with_corner_0(const CornerBlocks& k, std::array<Eigen::Matrix3d, 10>& blocks) {
  blocks[2] = k[0];
  blocks[4] = k[1];
  blocks[5] = k[2];
  blocks[7] = k[3];
  blocks[8] = k[4];
  blocks[9] = k[5];
  blocks[1] = -(k[0] + k[1].transpose() + k[3].transpose());
  blocks[3] = -(k[1] + k[2] + k[4].transpose());
  blocks[6] = -(k[3] + k[4] + k[5]);
  blocks[0] = -(blocks[1] + blocks[3] + blocks[6]);
}

inline void add_element(const std::array<Eigen::Matrix3d, 10>& corner, int /*point*/,
                        std::array<Eigen::Matrix3d, 10>& blocks) {
  blocks = corner;
}

/// Each node's displacement is a sum of corner values (quadrature.hpp), so each block is a sum of corner blocks.
inline void add_element(const std::array<Eigen::Matrix3d, 10>& corner, int point,
                        std::array<Eigen::Matrix3d, 55>& blocks) {
  const auto l = [point](int c) { return c == point ? tet_near : tet_far; };
  // T_ad = sum_c w_ac k_cd, from node a to corner d.
  std::array<std::array<Eigen::Matrix3d, 4>, 10> T;
  std::array<std::array<Eigen::Matrix3d, 4>, 4> k;
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t d = 0; d <= c; ++d) {
      k[c][d] = corner[c * (c + 1) / 2 + d];
      if (c != d) k[d][c] = k[c][d].transpose();
    }
  }
  for (std::size_t d = 0; d < 4; ++d) {
    for (std::size_t c = 0; c < 4; ++c) T[c][d] = (4 * l(static_cast<int>(c)) - 1) * k[c][d];
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [a, b] = tet_edges[e];
      T[4 + e][d] = 4 * l(b) * k[static_cast<std::size_t>(a)][d] + 4 * l(a) * k[static_cast<std::size_t>(b)][d];
    }
  }
  std::size_t n = 0;
  for (std::size_t a = 0; a < 10; ++a) {
    for (std::size_t b = 0; b <= a; ++b, ++n) {
      if (b < 4) {
        blocks[n] += (4 * l(static_cast<int>(b)) - 1) * T[a][b];
      } else {
        const auto [c, d] = tet_edges[b - 4];
        blocks[n] += 4 * l(d) * T[a][static_cast<std::size_t>(c)] + 4 * l(c) * T[a][static_cast<std::size_t>(d)];
      }
    }
  }
}

}  // namespace

template <std::size_t size>
void ElasticModel::gather(std::size_t element, const Eigen::VectorXd& x, std::array<Eigen::Vector3d, size>& at) const {
  for (std::size_t k = 0; k < size; ++k) at[k] = x.segment<3>(3 * corners_[element * size + k]);
}

template <std::size_t size>
void ElasticModel::add_force(std::size_t element, const std::array<Eigen::Vector3d, size>& force, double* f) const {
  for (std::size_t k = 0; k < size; ++k) {
    const int unknown = unknown_of(corners_[element * size + k]);
    if (unknown < 0) continue;
    for (int i = 0; i < 3; ++i) f[unknown + i] += force[k][i];
  }
}

void ElasticModel::add_blocks(std::size_t element, const Eigen::Matrix3d* blocks, double* values) const {
  const auto size = static_cast<std::size_t>(size_);
  const BlockPlace* place = &places_[element * size * (size + 1) / 2];
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < i; ++j, ++place, ++blocks) {
      if (place->at < 0) continue;
      // Columns of a node are one shorter each, above the diagonal.
      double* const first = values + place->at;
      double* const second = first + place->length - 1;
      double* const third = second + place->length - 2;
      const double* const block = blocks->data();
      for (int row = 0; row < 3; ++row) {
        first[row] += block[row];
        second[row] += block[3 + row];
        third[row] += block[6 + row];
      }
    }
    if (place->at >= 0) {
      double* const first = values + place->at;
      const double* const block = blocks->data();
      first[0] += block[0];
      first[1] += block[1];
      first[2] += block[2];
      first[place->length] += block[4];
      first[place->length + 1] += block[5];
      first[2 * place->length - 1] += block[8];
    }
    ++place;
    ++blocks;
  }
}

template <class Law, std::size_t size>
double ElasticModel::energy_by(const Eigen::VectorXd& x) const {
  double sum = 0;
  std::array<Eigen::Vector3d, size> at;
  Corners y;
  Eigen::Matrix3d F;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    const Law law({element.mu, element.lambda});
    gather(e, x, at);
    double density = 0;
    for (int point = 0; point < points<size>; ++point) {
      corner_values(at, point, y);
      deformation(y, element.gradient, F);
      density += law.energy(F);
    }
    sum += element.volume / points<size> * density;
  }
  return sum;
}

template <class Law, std::size_t size>
void ElasticModel::force_by(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
  std::array<Eigen::Vector3d, size> at, force;
  Corners y;
  Eigen::Matrix3d F, P;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    const Law law({element.mu, element.lambda});
    gather(e, x, at);
    force.fill(Eigen::Vector3d::Zero());
    for (int point = 0; point < points<size>; ++point) {
      corner_values(at, point, y);
      deformation(y, element.gradient, F);
      law.stress(F, P);
      corner_forces(P, element.gradient, element.volume / points<size>, y);
      add_node_values(y, point, force);
    }
    add_force(e, force, f.data());
  }
}

template <class Law, std::size_t size>
void ElasticModel::assemble_by(const Eigen::VectorXd& x, Tangent tangent, double* values, Eigen::VectorXd& f) const {
  std::array<Eigen::Vector3d, size> at, force;
  std::array<Eigen::Matrix3d, size*(size + 1) / 2> blocks;
  std::array<Eigen::Matrix3d, 10> corner_blocks;
  CornerBlocks k;
  Corners y;
  Eigen::Matrix3d F, P, R;
  SignedSvd svd;
  PrincipalTangent principal;
  const double exact_share = tangent == Tangent::exact ? 1 : 0.5;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const Element& element = elements_[e];
    const Law law({element.mu, element.lambda});
    const double weight = element.volume / points<size>;
    gather(e, x, at);
    force.fill(Eigen::Vector3d::Zero());
    if (size != 4) blocks.fill(Eigen::Matrix3d::Zero());
    for (int point = 0; point < points<size>; ++point) {
      corner_values(at, point, y);
      deformation(y, element.gradient, F);
      bool is_known = false;
      if constexpr (std::is_same_v<Law, CorotationalLaw>) {
        if (tangent != Tangent::projected) {
          law.rotated_stress(F, P, R);
          warped_blocks(R, element.gradient, weight * element.mu, weight * element.lambda, k);
          is_known = tangent == Tangent::warped || add_turning(F, R, law, element.gradient, weight, exact_share, k);
        }
      }
      if (!is_known) {
        law.tangent(F, P, svd, principal);
        if (tangent == Tangent::projected) project(principal);
        if (tangent == Tangent::mean) halve(principal);
        principal_blocks(svd, principal, element.gradient, weight, k);
      }
      corner_forces(P, element.gradient, weight, y);
      add_node_values(y, point, force);
      with_corner_0(k, corner_blocks);
      add_element(corner_blocks, point, blocks);
    }
    add_force(e, force, f.data());
    add_blocks(e, blocks.data(), values);
  }
}

template <std::size_t size>
double ElasticModel::smallest_ratio(const Eigen::VectorXd& x) const {
  double least = 1;
  std::array<Eigen::Vector3d, size> at;
  Corners y;
  Eigen::Matrix3d F;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    gather(e, x, at);
    for (int point = 0; point < points<size>; ++point) {
      corner_values(at, point, y);
      deformation(y, elements_[e].gradient, F);
      const double ratio = F.determinant();
      least = e == 0 && point == 0 ? ratio : std::min(least, ratio);
    }
  }
  return least;
}

double ElasticModel::energy(const Eigen::VectorXd& x) const {
  TACTOR_DEMAND(x.size() == 3 * nodes());
  const bool linear = order_ == ElementOrder::linear;
  if (law_ == Elasticity::corotational)
    return linear ? energy_by<CorotationalLaw, 4>(x) : energy_by<CorotationalLaw, 10>(x);
  return linear ? energy_by<NeoHookeanLaw, 4>(x) : energy_by<NeoHookeanLaw, 10>(x);
}

void ElasticModel::force(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
  TACTOR_DEMAND(x.size() == 3 * nodes());
  f.setZero(unknowns());
  const bool linear = order_ == ElementOrder::linear;
  if (law_ == Elasticity::corotational) {
    linear ? force_by<CorotationalLaw, 4>(x, f) : force_by<CorotationalLaw, 10>(x, f);
  } else {
    linear ? force_by<NeoHookeanLaw, 4>(x, f) : force_by<NeoHookeanLaw, 10>(x, f);
  }
}

void ElasticModel::assemble(const Eigen::VectorXd& x, Tangent tangent, Eigen::SparseMatrix<double>& K,
                            Eigen::VectorXd& f) const {
  TACTOR_DEMAND(x.size() == 3 * nodes());
  if (K.rows() != mass_.rows() || K.nonZeros() != mass_.nonZeros() || !K.isCompressed()) K = mass_;
  std::fill_n(K.valuePtr(), K.nonZeros(), 0.0);
  f.setZero(unknowns());
  double* const values = K.valuePtr();
  const bool linear = order_ == ElementOrder::linear;
  if (law_ == Elasticity::corotational) {
    linear ? assemble_by<CorotationalLaw, 4>(x, tangent, values, f)
           : assemble_by<CorotationalLaw, 10>(x, tangent, values, f);
  } else {
    const Tangent full = tangent == Tangent::warped ? Tangent::projected : tangent;
    linear ? assemble_by<NeoHookeanLaw, 4>(x, full, values, f) : assemble_by<NeoHookeanLaw, 10>(x, full, values, f);
  }
}

double ElasticModel::smallest_volume_ratio(const Eigen::VectorXd& x) const {
  TACTOR_DEMAND(x.size() == 3 * nodes());
  return order_ == ElementOrder::linear ? smallest_ratio<4>(x) : smallest_ratio<10>(x);
}

}  // namespace tactor
