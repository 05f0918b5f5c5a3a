#include "nodes/physics/deformable/step_factor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactor {

namespace {

constexpr double fresh_contraction = 0.1;        // of what an iteration leaves with a factor of where it is
constexpr double least_to_learn = 0.05;          // of what one leaves, where the factor learns from it
constexpr double slowest_contraction = 0.95;     // taken for iterations that leave more, or all
constexpr double largest_change_of_step = 0.15;  // that a factor serves
// Of a step, in multiplications as fast as those of a factorisation: of an entry of the factor in a solution, which
// waits for memory, and of a tetrahedron in forces and in an assembly.
constexpr double cost_of_entry = 12, cost_of_forces = 2500, cost_of_assembly = 2500;

double mass_share(const SoftBody& body, double h) {
  return 1 / (h * h) + body.drag / h;
}

double stiffness_share(const SoftBody& body, double h) {
  return 1 + body.damping / h;
}

}  // namespace

StepFactor::StepFactor(const ElasticModel& model, FactorKind kind)
    : model_(model), factor_(make_factor(kind, model.elements())) {}

void StepFactor::reorder(std::vector<int> last_nodes) {
  last_nodes_ = std::move(last_nodes);
  analysed_ = false;
  forget();
}

bool StepFactor::factor(const Eigen::VectorXd& x, double h, ElasticModel::Tangent tangent) {
  model_.assemble(x, tangent, K_, force_);
  if (A_.rows() == 0) A_ = K_;
  const Eigen::SparseMatrix<double>& M = model_.mass();
  for (Eigen::Index column = 0; column < A_.outerSize(); ++column) {
    const SoftBody& body = model_.bodies()[static_cast<std::size_t>(model_.body_of(static_cast<int>(column)))];
    const double m = mass_share(body, h), k = stiffness_share(body, h);
    for (Eigen::Index i = A_.outerIndexPtr()[column]; i < A_.outerIndexPtr()[column + 1]; ++i) {
      A_.valuePtr()[i] = m * M.valuePtr()[i] + k * K_.valuePtr()[i];
    }
  }
  if (!analysed_) {
    factor_.analyze(A_, last_nodes_);
    analysed_ = true;
  }
  wasted_ = 0;
  // Of finite numbers it has one.
  h_ = factor_.factor(A_) ? h : 0;
  if (h_ == 0) return false;
  stiffest_ = A_.diagonal().norm();
  return true;
}

bool StepFactor::serves(double h) const {
  return std::abs(h_ - h) <= largest_change_of_step * h;
}

bool StepFactor::is_due(double contraction, double excess, int to_go, bool fresh) {
  if (!std::isfinite(contraction)) return true;
  const double speed = -std::log(std::clamp(contraction, 1e-12, slowest_contraction));
  if (std::log(excess) > speed * to_go) return true;
  if (fresh) return false;
  wasted_ += std::clamp(1 - std::log(contraction) / std::log(fresh_contraction), 0.0, 2.0);
  return wasted_ > iterations_it_is_worth();
}

bool StepFactor::learn(double contraction, const Eigen::VectorXd& s, const Eigen::VectorXd& y) {
  return contraction > least_to_learn && factor_.update(s, y);
}

double StepFactor::iterations_it_is_worth() const {
  const double tetrahedra = model_.elements();
  // Two solutions, and one where the factor learns.
  const double iteration =
      3 * cost_of_entry * static_cast<double>(factor_.base().entries()) + cost_of_forces * tetrahedra;
  return (factor_.base().multiplications() + cost_of_assembly * tetrahedra) / iteration;
}

}  // namespace tactor
