// Sparse symmetric matrices of three unknowns a node: the graph of their nodes, and the matrix in the order of
// elimination.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace tactor {

/// Neighbours of each node: those of node n are to[first[n]] ... to[first[n + 1] - 1], ascending, without n itself.
struct NodeGraph {
  std::vector<int> first, to;
  [[nodiscard]] int size() const { return static_cast<int>(first.size()) - 1; }
};

/// The graph of a matrix that is given by its lower triangle.
NodeGraph node_graph(const Eigen::SparseMatrix<double>& A);

/// An order in which nodes are eliminated: found once for a pattern, and changed where other nodes have to come last.
class EliminationOrder {
 public:
  /// `find` gives the nodes of a graph in an order of elimination that keeps the factor sparse. It is called where A
  /// has another pattern than before. Returns that order, but with the nodes `last` at the end in their own order.
  std::vector<int> of(const Eigen::SparseMatrix<double>& A, std::span<const int> last,
                      const std::function<std::vector<int>(const NodeGraph&)>& find);

 private:
  std::vector<int> outer_, inner_;  ///< of the pattern
  std::vector<int> order_;
};

/// A matrix in another order of its nodes, as the triangle that a factorisation reads.
class ReorderedMatrix {
 public:
  enum class Triangle { lower, upper };

  /// `order`: the nodes in the order of elimination. A by its lower triangle.
  void analyze(const Eigen::SparseMatrix<double>& A, std::vector<int> order, Triangle triangle);
  /// Takes over the values of a matrix with the pattern of A.
  void take(const Eigen::SparseMatrix<double>& A);

  [[nodiscard]] const Eigen::SparseMatrix<double>& matrix() const { return matrix_; }
  /// To and from the order of elimination; vectors of the unknowns.
  void into_order(const Eigen::VectorXd& b, Eigen::VectorXd& ordered) const;
  void out_of_order(const Eigen::VectorXd& ordered, Eigen::VectorXd& b) const;

 private:
  std::vector<int> order_;
  std::vector<int> from_;  ///< for each value, which of A it is
  Eigen::SparseMatrix<double> matrix_;
};

}  // namespace tactor
