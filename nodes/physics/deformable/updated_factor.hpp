// A sparse factor that learns from what steps do how the matrix has changed since.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "nodes/physics/deformable/sparse_factor.hpp"

namespace tactor {

/// The inverse H of a matrix A that changes slowly: the factor of the A of an earlier step, P, and the pairs (s, y)
/// since, y being by how much the forces changed over the way s, so that A s = y. For each pair, from the oldest to the
/// newest, by the BFGS formula,
///   H' = (I - s y^T / (y . s)) H (I - y s^T / (y . s)) + s s^T / (y . s),
/// which is symmetric positive definite and has H' y = s. So `solve` is that of L-BFGS with P as the first matrix (T.
/// Liu, S. Bouaziz, L. Kavan, "Quasi-Newton methods for real-time simulation of hyperelastic materials", TOG 2017), and
/// `schur` is the Schur complement of H^-1: contacts that are solved with it and forces that are put through `solve`
/// agree. On a linear problem it does as conjugate gradients preconditioned with P do, without assembling A.
class UpdatedFactor {
 public:
  explicit UpdatedFactor(std::unique_ptr<SparseFactor> factor);

  /// Of the matrix itself; see SparseFactor. Pairs are forgotten.
  void analyze(const Eigen::SparseMatrix<double>& A, std::span<const int> last_nodes);
  bool factor(const Eigen::SparseMatrix<double>& A);
  /// b becomes H b.
  void solve(Eigen::VectorXd& b) const;
  /// N/m, on the unknowns of the last nodes in their order: the inverse of the block of H that is theirs.
  [[nodiscard]] const Eigen::MatrixXd& schur() const { return schur_; }

  /// Takes in that the forces change by `y` over the way `s`; the oldest pair is forgotten where there are too many.
  /// False, and nothing has changed, where y . s is not clearly positive, as where a body buckles.
  bool update(const Eigen::VectorXd& s, const Eigen::VectorXd& y);
  /// How many pairs there are.
  [[nodiscard]] std::size_t pairs() const { return count_; }
  static constexpr std::size_t most_pairs = 8;

  [[nodiscard]] const SparseFactor& base() const { return *factor_; }

 private:
  struct Pair {
    Eigen::VectorXd s, y, solved;  ///< m, N, and P^-1 y
    double share = 0;              ///< 1 / (y . s)
  };
  [[nodiscard]] const Pair& pair(std::size_t i) const { return pairs_[(first_ + i) % most_pairs]; }
  void add_to_schur(std::size_t i);
  void on_last(const Eigen::VectorXd& all, Eigen::Ref<Eigen::VectorXd> last) const;

  std::unique_ptr<SparseFactor> factor_;
  std::vector<int> last_;
  std::array<Pair, most_pairs> pairs_;  ///< a ring, the oldest at first_
  std::size_t first_ = 0, count_ = 0;
  Eigen::MatrixXd of_factor_, schur_;
  Eigen::VectorXd q_, w_;
  Eigen::MatrixXd ways_, pushes_;  ///< of the last nodes, two columns
};

}  // namespace tactor
