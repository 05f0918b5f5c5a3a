#include "nodes/physics/deformable/elimination.hpp"

#include <algorithm>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

NodeGraph node_graph(const Eigen::SparseMatrix<double>& A) {
  TACTOR_DEMAND(A.rows() == A.cols() && A.rows() % 3 == 0 && A.isCompressed());
  const int nodes = static_cast<int>(A.rows()) / 3;
  std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(nodes));
  for (int column = 0; column < A.cols(); ++column) {
    for (int k = A.outerIndexPtr()[column]; k < A.outerIndexPtr()[column + 1]; ++k) {
      const int a = column / 3, b = A.innerIndexPtr()[k] / 3;
      if (a == b) continue;
      // Blocks are mostly full: one entry of each would do, but others are not excluded.
      std::vector<int>& of_a = neighbours[static_cast<std::size_t>(a)];
      if (!of_a.empty() && of_a.back() == b) continue;
      of_a.push_back(b);
      neighbours[static_cast<std::size_t>(b)].push_back(a);
    }
  }
  NodeGraph graph;
  graph.first.push_back(0);
  for (std::vector<int>& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    graph.to.insert(graph.to.end(), list.begin(), list.end());
    graph.first.push_back(static_cast<int>(graph.to.size()));
  }
  return graph;
}

std::vector<int> nodes_before(int nodes, std::span<const int> last) {
  std::vector<char> is_last(static_cast<std::size_t>(nodes), 0);
  for (const int node : last) {
    TACTOR_DEMAND(node >= 0 && node < nodes && is_last[static_cast<std::size_t>(node)] == 0);
    is_last[static_cast<std::size_t>(node)] = 1;
  }
  std::vector<int> before;
  for (int node = 0; node < nodes; ++node) {
    if (is_last[static_cast<std::size_t>(node)] == 0) before.push_back(node);
  }
  return before;
}

NodeGraph part_of(const NodeGraph& graph, const std::vector<int>& nodes) {
  std::vector<int> place(static_cast<std::size_t>(graph.size()), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) place[static_cast<std::size_t>(nodes[i])] = static_cast<int>(i);
  NodeGraph part;
  part.first.push_back(0);
  for (const int node : nodes) {
    for (int k = graph.first[static_cast<std::size_t>(node)]; k < graph.first[static_cast<std::size_t>(node) + 1];
         ++k) {
      const int other = place[static_cast<std::size_t>(graph.to[static_cast<std::size_t>(k)])];
      if (other >= 0) part.to.push_back(other);
    }
    part.first.push_back(static_cast<int>(part.to.size()));
  }
  return part;
}

void ReorderedMatrix::analyze(const Eigen::SparseMatrix<double>& A, std::vector<int> order, Triangle triangle) {
  order_ = std::move(order);
  TACTOR_DEMAND(3 * static_cast<Eigen::Index>(order_.size()) == A.rows());
  std::vector<int> place(order_.size());
  for (std::size_t k = 0; k < order_.size(); ++k) place[static_cast<std::size_t>(order_[k])] = static_cast<int>(k);
  struct Entry {
    int column, row, from;
  };
  std::vector<Entry> entries;
  entries.reserve(static_cast<std::size_t>(A.nonZeros()));
  for (int column = 0; column < A.cols(); ++column) {
    for (int k = A.outerIndexPtr()[column]; k < A.outerIndexPtr()[column + 1]; ++k) {
      const int row = A.innerIndexPtr()[k];
      if (row < column) continue;
      int i = 3 * place[static_cast<std::size_t>(row / 3)] + row % 3,
          j = 3 * place[static_cast<std::size_t>(column / 3)] + column % 3;
      if ((triangle == Triangle::lower) != (i >= j)) std::swap(i, j);
      entries.push_back({j, i, k});
    }
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.column != b.column ? a.column < b.column : a.row < b.row; });
  matrix_.resize(A.rows(), A.cols());
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(entries.size()));
  from_.resize(entries.size());
  std::fill_n(matrix_.outerIndexPtr(), A.cols() + 1, 0);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    ++matrix_.outerIndexPtr()[entries[k].column + 1];
    matrix_.innerIndexPtr()[k] = entries[k].row;
    from_[k] = entries[k].from;
  }
  for (int column = 0; column < A.cols(); ++column)
    matrix_.outerIndexPtr()[column + 1] += matrix_.outerIndexPtr()[column];
  take(A);
}

void ReorderedMatrix::take(const Eigen::SparseMatrix<double>& A) {
  const double* const from = A.valuePtr();
  double* const to = matrix_.valuePtr();
  for (std::size_t k = 0; k < from_.size(); ++k) to[k] = from[from_[k]];
}

void ReorderedMatrix::into_order(const Eigen::VectorXd& b, Eigen::VectorXd& ordered) const {
  for (std::size_t k = 0; k < order_.size(); ++k)
    ordered.segment<3>(3 * static_cast<Eigen::Index>(k)) = b.segment<3>(3 * order_[k]);
}

void ReorderedMatrix::out_of_order(const Eigen::VectorXd& ordered, Eigen::VectorXd& b) const {
  for (std::size_t k = 0; k < order_.size(); ++k)
    b.segment<3>(3 * order_[k]) = ordered.segment<3>(3 * static_cast<Eigen::Index>(k));
}

}  // namespace tactor
