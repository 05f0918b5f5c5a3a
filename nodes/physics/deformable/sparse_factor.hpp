// Cholesky factors of sparse matrices, whichever library computes them.
#pragma once

#include <memory>
#include <span>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace tactor {

/// The Cholesky factor L L^T of a symmetric positive definite matrix A with three unknowns a node (unknown / 3), as
/// ElasticModel makes it. Of A only the lower triangle is read; its indices ascend in each column.
class SparseFactor {
 public:
  virtual ~SparseFactor() = default;

  /// Chooses the order of elimination by the pattern of A and makes room for the factor. The nodes `last_nodes`, all
  /// different, are eliminated last, in that order. Called again with the same pattern and other last nodes, it keeps
  /// the order of the rest, and so takes less time.
  virtual void analyze(const Eigen::SparseMatrix<double>& A, std::span<const int> last_nodes) = 0;
  /// A has the pattern of the matrix that was analysed. False where it is not positive definite; there is no factor
  /// then.
  virtual bool factor(const Eigen::SparseMatrix<double>& A) = 0;
  /// b becomes A^-1 b. Does not allocate.
  virtual void solve(Eigen::VectorXd& b) const = 0;
  /// The Schur complement of A on the unknowns of the last nodes, in their order: the inverse of the block of A^-1 that
  /// is theirs. L_pp L_pp^T with L_pp the last block of L. Full, symmetric.
  virtual void schur(Eigen::MatrixXd& S) const = 0;
  /// Entries of L on and below the diagonal that the method stores.
  [[nodiscard]] virtual std::size_t entries() const = 0;
  /// Multiplications of a factorisation, about: the sum of the squares of the entries in each column of L.
  [[nodiscard]] virtual double multiplications() const = 0;
  [[nodiscard]] virtual const char* name() const = 0;
};

enum class FactorKind {
  automatic,   ///< eigen where there are few tetrahedra or the plugin is missing, else supernodal
  eigen,       ///< Eigen's SimplicialLLT. The same numbers on all processors
  simplicial,  ///< CHOLMOD without BLAS. The same numbers on all processors
  portable,    ///< eigen where there are few tetrahedra or the plugin is missing, else simplicial
  supernodal,  ///< CHOLMOD by a BLAS on one thread, which picks its code by the processor: last digits differ between
               ///< them
};

/// From so many tetrahedra on, `automatic` is supernodal, and `portable` simplicial; without the plugin both are eigen.
inline constexpr int least_for_supernodal = 1000, least_for_simplicial = 10'000;

/// What `automatic` is for so many tetrahedra, and why, in words.
struct FactorChoice {
  FactorKind kind = FactorKind::eigen;
  const char* why = "";
};
FactorChoice chosen_factor(int tetrahedra);

/// Throws InputError where simplicial or supernodal is asked for and the plugin tactor_suitesparse is not installed.
std::unique_ptr<SparseFactor> make_factor(FactorKind kind, int tetrahedra);

}  // namespace tactor
