#include "nodes/physics/deformable/eigen_factor.hpp"

#include <algorithm>
#include <vector>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>

#include "framework/core/check.hpp"
#include "nodes/physics/deformable/elimination.hpp"

namespace tactor {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Nodes of the graph in the order of elimination.
std::vector<int> least_degree_first(const NodeGraph& graph) {
  // With the diagonal: Eigen puts nodes without it last, as dense ones.
  Eigen::SparseMatrix<double> pattern(graph.size(), graph.size());
  pattern.resizeNonZeros(static_cast<Eigen::Index>(graph.to.size()) + graph.size());
  int at = 0;
  for (int node = 0; node < graph.size(); ++node) {
    pattern.outerIndexPtr()[node] = at;
    bool has_diagonal = false;
    for (int k = graph.first[static_cast<std::size_t>(node)]; k < graph.first[static_cast<std::size_t>(node) + 1];
         ++k) {
      const int other = graph.to[static_cast<std::size_t>(k)];
      if (other > node && !has_diagonal) pattern.innerIndexPtr()[at++] = node;
      has_diagonal |= other > node;
      pattern.innerIndexPtr()[at++] = other;
    }
    if (!has_diagonal) pattern.innerIndexPtr()[at++] = node;
  }
  pattern.outerIndexPtr()[graph.size()] = at;
  std::fill_n(pattern.valuePtr(), pattern.nonZeros(), 1.0);
  Eigen::AMDOrdering<int>::PermutationType order;
  if (graph.size() > 0) Eigen::AMDOrdering<int>()(pattern, order);
  return {order.indices().data(), order.indices().data() + order.indices().size()};
}

}  // namespace

struct EigenFactor::Impl {
  EliminationOrder order;
  ReorderedMatrix reordered;
  Eigen::SimplicialLLT<Sparse, Eigen::Upper, Eigen::NaturalOrdering<int>> llt;
  Eigen::Index last = 0;  ///< unknowns of the last nodes
  mutable Eigen::VectorXd ordered;
  bool is_factored = false;
};

EigenFactor::EigenFactor() : impl_(std::make_unique<Impl>()) {}
EigenFactor::~EigenFactor() = default;

void EigenFactor::analyze(const Sparse& A, std::span<const int> last_nodes) {
  impl_->reordered.analyze(A, impl_->order.of(A, last_nodes, least_degree_first), ReorderedMatrix::Triangle::upper);
  impl_->llt.analyzePattern(impl_->reordered.matrix());
  impl_->last = 3 * static_cast<Eigen::Index>(last_nodes.size());
  impl_->ordered.resize(A.rows());
  impl_->is_factored = false;
}

bool EigenFactor::factor(const Sparse& A) {
  impl_->reordered.take(A);
  impl_->llt.factorize(impl_->reordered.matrix());
  impl_->is_factored = impl_->llt.info() == Eigen::Success;
  return impl_->is_factored;
}

void EigenFactor::solve(Eigen::VectorXd& b) const {
  TACTOR_DEMAND(impl_->is_factored && b.size() == impl_->ordered.size());
  impl_->reordered.into_order(b, impl_->ordered);
  impl_->llt.matrixL().solveInPlace(impl_->ordered);
  impl_->llt.matrixU().solveInPlace(impl_->ordered);
  impl_->reordered.out_of_order(impl_->ordered, b);
}

void EigenFactor::schur(Eigen::MatrixXd& S) const {
  TACTOR_DEMAND(impl_->is_factored);
  const Eigen::Index first = impl_->ordered.size() - impl_->last;
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(impl_->last, impl_->last);
  const Sparse& factor = impl_->llt.matrixL().nestedExpression();
  for (Eigen::Index column = 0; column < impl_->last; ++column) {
    for (Sparse::InnerIterator it(factor, first + column); it; ++it) L(it.row() - first, column) = it.value();
  }
  S.noalias() = L * L.transpose();
}

std::size_t EigenFactor::entries() const {
  return static_cast<std::size_t>(impl_->llt.matrixL().nestedExpression().nonZeros());
}

double EigenFactor::multiplications() const {
  const Sparse& L = impl_->llt.matrixL().nestedExpression();
  double sum = 0;
  for (Eigen::Index column = 0; column < L.cols(); ++column) {
    const double height = L.outerIndexPtr()[column + 1] - L.outerIndexPtr()[column];
    sum += height * height;
  }
  return sum;
}

}  // namespace tactor
