// Sparse symmetric matrices of three unknowns a node: the graph of their nodes, and the matrix in the order of
// elimination.
#pragma once

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

/// The nodes that are not among `last`, ascending.
std::vector<int> nodes_before(int nodes, std::span<const int> last);

/// The graph of some of the nodes, which become 0, 1, ... in their order.
NodeGraph part_of(const NodeGraph& graph, const std::vector<int>& nodes);

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
