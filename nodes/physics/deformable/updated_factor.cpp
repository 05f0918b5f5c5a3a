#include "nodes/physics/deformable/updated_factor.hpp"

#include <utility>

#include <Eigen/LU>

namespace tactor {

namespace {

/// Cosine of the angle between s and y below which a pair is left out.
constexpr double least_cosine = 1e-4;

}  // namespace

UpdatedFactor::UpdatedFactor(std::unique_ptr<SparseFactor> factor) : factor_(std::move(factor)) {}

void UpdatedFactor::analyze(const Eigen::SparseMatrix<double>& A, std::span<const int> last_nodes) {
  factor_->analyze(A, last_nodes);
  last_.assign(last_nodes.begin(), last_nodes.end());
  q_.resize(A.rows());
  w_.resize(A.rows());
  for (Pair& pair : pairs_) {
    for (Eigen::VectorXd* v : {&pair.s, &pair.y, &pair.solved}) v->resize(A.rows());
  }
  ways_.resize(3 * static_cast<Eigen::Index>(last_.size()), 2);
  pushes_.resize(ways_.rows(), 2);
  count_ = 0;
}

bool UpdatedFactor::factor(const Eigen::SparseMatrix<double>& A) {
  first_ = count_ = 0;
  if (!factor_->factor(A)) return false;
  if (last_.empty()) {
    of_factor_.resize(0, 0);
  } else {
    factor_->schur(of_factor_);
  }
  schur_ = of_factor_;
  return true;
}

void UpdatedFactor::solve(Eigen::VectorXd& b) const {
  std::array<double, most_pairs> along{};
  for (std::size_t i = count_; i-- > 0;) {
    along[i] = pair(i).share * pair(i).s.dot(b);
    b -= along[i] * pair(i).y;
  }
  factor_->solve(b);
  for (std::size_t i = 0; i < count_; ++i) {
    b += (along[i] - pair(i).share * pair(i).y.dot(b)) * pair(i).s;
  }
}

bool UpdatedFactor::update(const Eigen::VectorXd& s, const Eigen::VectorXd& y) {
  const double along = s.dot(y);
  if (!(along > least_cosine * s.norm() * y.norm())) return false;
  const bool full = count_ == most_pairs;
  if (full) {
    first_ = (first_ + 1) % most_pairs;
  } else {
    ++count_;
  }
  Pair& newest = pairs_[(first_ + count_ - 1) % most_pairs];
  newest.s = s;
  newest.y = newest.solved = y;
  newest.share = 1 / along;
  factor_->solve(newest.solved);
  if (last_.empty()) return true;
  if (full) {
    // Without the oldest all that came after is another.
    schur_ = of_factor_;
    for (std::size_t i = 0; i + 1 < count_; ++i) add_to_schur(i);
  }
  add_to_schur(count_ - 1);
  return true;
}

/// Brings schur_ from that of the pairs before i to that with it. On the last nodes the inverse changes by
/// U C U^T with U = [s, w], w = H y and C = [[g^2 y.w + g, -g], [-g, 0]], g = 1 / (y . s); the rest is Woodbury's
/// formula.
void UpdatedFactor::add_to_schur(std::size_t i) {
  // w by the pairs before, without another solution: P^-1 of a sum of y's is that of what was solved for them.
  const Pair& newest = pair(i);
  std::array<double, most_pairs> along{};
  q_ = newest.y;
  w_ = newest.solved;
  for (std::size_t k = i; k-- > 0;) {
    along[k] = pair(k).share * pair(k).s.dot(q_);
    q_ -= along[k] * pair(k).y;
    w_ -= along[k] * pair(k).solved;
  }
  for (std::size_t k = 0; k < i; ++k) w_ += (along[k] - pair(k).share * pair(k).y.dot(w_)) * pair(k).s;
  on_last(newest.s, ways_.col(0));
  on_last(w_, ways_.col(1));
  pushes_.noalias() = schur_ * ways_;
  Eigen::Matrix2d middle = ways_.transpose() * pushes_;
  middle(0, 1) = middle(1, 0) = middle(0, 1) - 1 / newest.share;
  middle(1, 1) -= newest.y.dot(w_) + 1 / newest.share;
  schur_.noalias() -= pushes_ * middle.inverse() * pushes_.transpose();
}

void UpdatedFactor::on_last(const Eigen::VectorXd& all, Eigen::Ref<Eigen::VectorXd> last) const {
  for (std::size_t i = 0; i < last_.size(); ++i) {
    last.segment<3>(static_cast<Eigen::Index>(3 * i)) = all.segment<3>(3 * last_[i]);
  }
}

}  // namespace tactor
