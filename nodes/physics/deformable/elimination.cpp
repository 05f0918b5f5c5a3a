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

std::vector<int> EliminationOrder::of(const Eigen::SparseMatrix<double>& A, std::span<const int> last,
                                      const std::function<std::vector<int>(const NodeGraph&)>& find) {
  const std::span<const int> outer(A.outerIndexPtr(), static_cast<std::size_t>(A.cols()) + 1);
  const std::span<const int> inner(A.innerIndexPtr(), static_cast<std::size_t>(A.nonZeros()));
  if (!std::ranges::equal(outer, outer_) || !std::ranges::equal(inner, inner_)) {
    order_ = find(node_graph(A));
    outer_.assign(outer.begin(), outer.end());
    inner_.assign(inner.begin(), inner.end());
  }
  std::vector<char> is_last(order_.size(), 0);
  for (const int node : last) {
    TACTOR_DEMAND(node >= 0 && static_cast<std::size_t>(node) < order_.size() &&
                  is_last[static_cast<std::size_t>(node)] == 0);
    is_last[static_cast<std::size_t>(node)] = 1;
  }
  std::vector<int> order;
  order.reserve(order_.size());
  for (const int node : order_) {
    if (is_last[static_cast<std::size_t>(node)] == 0) order.push_back(node);
  }
  order.insert(order.end(), last.begin(), last.end());
  return order;
}

void ReorderedMatrix::analyze(const Eigen::SparseMatrix<double>& A, std::vector<int> order, Triangle triangle) {
  order_ = std::move(order);
  TACTOR_DEMAND(3 * static_cast<Eigen::Index>(order_.size()) == A.rows());
  std::vector<int> place(order_.size());
  for (std::size_t k = 0; k < order_.size(); ++k) place[static_cast<std::size_t>(order_[k])] = static_cast<int>(k);
  const auto size = static_cast<std::size_t>(A.rows());
  struct Entry {
    int row, column, from;
  };
  // Sorted by row and then by column, each by counting.
  std::vector<Entry> entries, by_row;
  entries.reserve(static_cast<std::size_t>(A.nonZeros()));
  std::vector<int> rows(size + 1, 0), columns(size + 1, 0);
  for (int column = 0; column < A.cols(); ++column) {
    for (int k = A.outerIndexPtr()[column]; k < A.outerIndexPtr()[column + 1]; ++k) {
      const int row = A.innerIndexPtr()[k];
      if (row < column) continue;
      int i = 3 * place[static_cast<std::size_t>(row / 3)] + row % 3,
          j = 3 * place[static_cast<std::size_t>(column / 3)] + column % 3;
      if ((triangle == Triangle::lower) != (i >= j)) std::swap(i, j);
      entries.push_back({i, j, k});
      ++rows[static_cast<std::size_t>(i) + 1];
      ++columns[static_cast<std::size_t>(j) + 1];
    }
  }
  for (std::size_t k = 0; k < size; ++k) {
    rows[k + 1] += rows[k];
    columns[k + 1] += columns[k];
  }
  by_row.resize(entries.size());
  for (const Entry& entry : entries)
    by_row[static_cast<std::size_t>(rows[static_cast<std::size_t>(entry.row)]++)] = entry;
  matrix_.resize(A.rows(), A.cols());
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(entries.size()));
  std::copy(columns.begin(), columns.end(), matrix_.outerIndexPtr());
  from_.resize(entries.size());
  for (const Entry& entry : by_row) {
    const int at = columns[static_cast<std::size_t>(entry.column)]++;
    matrix_.innerIndexPtr()[at] = entry.row;
    from_[static_cast<std::size_t>(at)] = entry.from;
  }
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
