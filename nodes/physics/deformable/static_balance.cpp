#include "nodes/physics/deformable/static_balance.hpp"

#include <cmath>
#include <memory>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// The factor of the exact Hessian where that is positive definite, else of the projected one, else of that and just
/// enough of the mass. False where nothing helps.
bool factor_stiffness(const ElasticModel& model, const Eigen::VectorXd& x, SparseFactor& factor,
                      Eigen::SparseMatrix<double>& K, Eigen::VectorXd& elastic) {
  if (factor.factor(K)) return true;
  model.assemble(x, ElasticModel::Tangent::projected, K, elastic);
  if (factor.factor(K)) return true;
  const Eigen::SparseMatrix<double>& mass = model.mass();
  const double unit = K.diagonal().maxCoeff() / mass.diagonal().maxCoeff();
  double added = 0;
  for (double share = 1e-10; share < 1; share *= 100) {
    for (Eigen::Index k = 0; k < K.nonZeros(); ++k) K.valuePtr()[k] += (share - added) * unit * mass.valuePtr()[k];
    added = share;
    if (factor.factor(K)) return true;
  }
  return false;
}

}  // namespace

Balance settle(const ElasticModel& model, const Eigen::VectorXd& start, const Vec3& gravity,
               const Eigen::VectorXd& extra, const BalanceOptions& options) {
  TACTOR_DEMAND(start.size() == 3 * model.nodes() && (extra.size() == 0 || extra.size() == model.unknowns()));
  Balance balance;
  balance.x = start;
  if (model.unknowns() == 0) {
    balance.converged = true;
    return balance;
  }
  Eigen::VectorXd outer = model.weight(gravity);
  if (extra.size() != 0) outer += extra;
  Eigen::SparseMatrix<double> K;
  Eigen::VectorXd elastic, step, tried, tried_force;
  const std::unique_ptr<SparseFactor> factor = make_factor(options.factor, model.elements());
  factor->analyze(model.mass(), {});
  for (;; ++balance.steps) {
    model.assemble(balance.x, ElasticModel::Tangent::exact, K, elastic);
    const double forces = elastic.norm() + outer.norm();
    const double left = (elastic + outer).norm();
    // What rounding of the positions makes of forces, where there are none.
    const double rounding = 1e-15 * K.diagonal().maxCoeff() * model.rest().cwiseAbs().maxCoeff() *
                            std::sqrt(static_cast<double>(model.unknowns()));
    balance.residual = forces > 0 ? left / forces : 0;
    balance.converged = left <= options.tolerance * forces || left <= rounding;
    if (balance.converged || balance.steps == options.most_steps) return balance;
    if (!factor_stiffness(model, balance.x, *factor, K, elastic)) return balance;
    step = elastic + outer;
    factor->solve(step);
    // Along the step the energy falls by this a unit at first.
    const double slope = step.dot(elastic + outer);
    const double stored = model.energy(balance.x), done = model.work(outer, balance.x);
    const double rounding_of_energy = 1e-11 * (std::abs(stored) + std::abs(done));
    bool found = false;
    for (double share = 1; share > 1e-12 && !found; share *= 0.5) {
      tried = balance.x;
      model.displace(step, share, tried);
      const double change = model.energy(tried) - stored - (model.work(outer, tried) - done);
      found = std::isfinite(change) && change <= -1e-4 * share * slope;
      if (found || !(change <= rounding_of_energy)) continue;
      model.force(tried, tried_force);
      found = std::abs(step.dot(tried_force + outer)) <= 0.9 * slope;
    }
    if (!found) return balance;
    balance.x.swap(tried);
  }
}

}  // namespace tactor
