#include "nodes/physics/suitesparse/cholmod_factor.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <suitesparse/cholmod.h>

#include "framework/core/check.hpp"
#include "nodes/physics/deformable/elimination.hpp"
#include "nodes/physics/suitesparse/one_thread.hpp"

namespace tactor {

namespace {

/// From so many nodes on, METIS orders them better than minimum degree does.
constexpr int least_for_dissection = 600;

/// A matrix of ours as CHOLMOD sees it; `triangle`: 1 the upper, -1 the lower.
cholmod_sparse seen(const Eigen::SparseMatrix<double>& A, int triangle) {
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(A.rows());
  view.ncol = static_cast<std::size_t>(A.cols());
  view.nzmax = static_cast<std::size_t>(A.nonZeros());
  view.p = const_cast<int*>(A.outerIndexPtr());
  view.i = const_cast<int*>(A.innerIndexPtr());
  view.x = const_cast<double*>(A.valuePtr());
  view.stype = triangle;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

class CholmodFactor : public SparseFactor {
 public:
  explicit CholmodFactor(bool supernodal) : supernodal_(supernodal) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
    common_.final_ll = 1;
    common_.quick_return_if_not_posdef = 1;
    // The order is ours.
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_NATURAL;
    common_.postorder = 0;
  }
  ~CholmodFactor() override {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  CholmodFactor(const CholmodFactor&) = delete;
  CholmodFactor& operator=(const CholmodFactor&) = delete;

  void analyze(const Eigen::SparseMatrix<double>& A, std::span<const int> last_nodes) override {
    std::vector<int> order = order_.of(A, last_nodes, [this](const NodeGraph& graph) { return ordered(graph); });
    reordered_.analyze(A, std::move(order),
                       supernodal_ ? ReorderedMatrix::Triangle::lower : ReorderedMatrix::Triangle::upper);
    cholmod_free_factor(&factor_, &common_);
    cholmod_sparse view = seen(reordered_.matrix(), supernodal_ ? -1 : 1);
    factor_ = cholmod_analyze(&view, &common_);
    TACTOR_DEMAND(factor_ != nullptr && common_.status >= 0);
    multiplications_ = common_.fl;
    last_ = 3 * static_cast<Eigen::Index>(last_nodes.size());
    ordered_.resize(A.rows());
    rest_.resize(std::max<Eigen::Index>(1, static_cast<Eigen::Index>(factor_->maxesize)));
    is_factored_ = false;
  }

  bool factor(const Eigen::SparseMatrix<double>& A) override {
    TACTOR_DEMAND(factor_ != nullptr);
    reordered_.take(A);
    cholmod_sparse view = seen(reordered_.matrix(), supernodal_ ? -1 : 1);
    double beta[2] = {0, 0};
    // The matrix stands as the factorisation reads it, so that CHOLMOD makes no copy of it.
    if (supernodal_) {
      const WithoutOpenMp one_thread;
      cholmod_super_numeric(&view, nullptr, beta, factor_, &common_);
    } else {
      cholmod_factorize_p(&view, beta, nullptr, 0, factor_, &common_);
    }
    TACTOR_DEMAND(common_.status >= 0);
    is_factored_ = common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
    return is_factored_;
  }

  void solve(Eigen::VectorXd& b) const override {
    TACTOR_DEMAND(is_factored_ && b.size() == ordered_.size());
    reordered_.into_order(b, ordered_);
    supernodal_ ? solve_by_supernodes() : solve_by_columns();
    reordered_.out_of_order(ordered_, b);
  }

  void schur(Eigen::MatrixXd& S) const override {
    TACTOR_DEMAND(is_factored_);
    Eigen::MatrixXd L = Eigen::MatrixXd::Zero(last_, last_);
    const auto first = static_cast<int>(ordered_.size() - last_);
    const auto* const x = static_cast<const double*>(factor_->x);
    if (supernodal_) {
      const auto *super = static_cast<const int*>(factor_->super), *pi = static_cast<const int*>(factor_->pi);
      const auto *px = static_cast<const int*>(factor_->px), *rows = static_cast<const int*>(factor_->s);
      for (auto s = static_cast<int>(factor_->nsuper) - 1; s >= 0 && super[s + 1] > first; --s) {
        const int height = pi[s + 1] - pi[s];
        for (int column = std::max(super[s], first); column < super[s + 1]; ++column) {
          const double* const values = x + px[s] + (column - super[s]) * height;
          for (int k = column - super[s]; k < height; ++k) L(rows[pi[s] + k] - first, column - first) = values[k];
        }
      }
    } else {
      const auto *p = static_cast<const int*>(factor_->p), *i = static_cast<const int*>(factor_->i),
                 *nz = static_cast<const int*>(factor_->nz);
      for (int column = first; column < first + static_cast<int>(last_); ++column) {
        for (int k = p[column]; k < p[column] + nz[column]; ++k) L(i[k] - first, column - first) = x[k];
      }
    }
    S.noalias() = L * L.transpose();
  }

  [[nodiscard]] std::size_t entries() const override { return supernodal_ ? factor_->xsize : factor_->nzmax; }
  [[nodiscard]] double multiplications() const override { return multiplications_; }
  [[nodiscard]] const char* name() const override { return supernodal_ ? "CHOLMOD supernodal" : "CHOLMOD simplicial"; }

 private:
  /// Nodes of the graph in the order of elimination.
  std::vector<int> ordered(const NodeGraph& graph) {
    std::vector<int> order(static_cast<std::size_t>(graph.size()));
    if (order.empty()) return order;
    // The upper triangle.
    std::vector<int> first{0}, to;
    for (int node = 0; node < graph.size(); ++node) {
      for (int k = graph.first[static_cast<std::size_t>(node)]; k < graph.first[static_cast<std::size_t>(node) + 1];
           ++k) {
        if (graph.to[static_cast<std::size_t>(k)] < node) to.push_back(graph.to[static_cast<std::size_t>(k)]);
      }
      first.push_back(static_cast<int>(to.size()));
    }
    cholmod_sparse view{};
    view.nrow = view.ncol = order.size();
    view.nzmax = to.size();
    view.p = first.data();
    view.i = to.data();
    view.stype = 1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_PATTERN;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    const int done = graph.size() < least_for_dissection ? cholmod_amd(&view, nullptr, 0, order.data(), &common_)
                                                         : cholmod_metis(&view, nullptr, 0, 1, order.data(), &common_);
    TACTOR_DEMAND(done != 0);
    return order;
  }

  void solve_by_supernodes() const {
    cholmod_dense b{};
    b.nrow = b.nzmax = b.d = static_cast<std::size_t>(ordered_.size());
    b.ncol = 1;
    b.x = ordered_.data();
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    cholmod_dense rest = b;
    rest.nrow = rest.nzmax = rest.d = static_cast<std::size_t>(rest_.size());
    rest.x = rest_.data();
    cholmod_super_lsolve(factor_, &b, &rest, &common_);
    cholmod_super_ltsolve(factor_, &b, &rest, &common_);
  }

  void solve_by_columns() const {
    const auto *p = static_cast<const int*>(factor_->p), *i = static_cast<const int*>(factor_->i),
               *nz = static_cast<const int*>(factor_->nz);
    const auto* const x = static_cast<const double*>(factor_->x);
    double* const b = ordered_.data();
    const auto n = static_cast<int>(ordered_.size());
    for (int column = 0; column < n; ++column) {
      const double value = b[column] /= x[p[column]];
      for (int k = p[column] + 1; k < p[column] + nz[column]; ++k) b[i[k]] -= x[k] * value;
    }
    for (int column = n - 1; column >= 0; --column) {
      double value = b[column];
      for (int k = p[column] + 1; k < p[column] + nz[column]; ++k) value -= x[k] * b[i[k]];
      b[column] = value / x[p[column]];
    }
  }

  bool supernodal_;
  mutable cholmod_common common_;
  cholmod_factor* factor_ = nullptr;
  EliminationOrder order_;
  ReorderedMatrix reordered_;
  Eigen::Index last_ = 0;  ///< unknowns of the last nodes
  mutable Eigen::VectorXd ordered_, rest_;
  double multiplications_ = 0;
  bool is_factored_ = false;
};

}  // namespace

std::unique_ptr<SparseFactor> make_simplicial_factor() {
  return std::make_unique<CholmodFactor>(false);
}

std::unique_ptr<SparseFactor> make_supernodal_factor() {
  use_one_blas_thread();
  return std::make_unique<CholmodFactor>(true);
}

}  // namespace tactor
