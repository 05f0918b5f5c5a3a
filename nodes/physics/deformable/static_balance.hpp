// Where elastic bodies come to rest.
#pragma once

#include <Eigen/Core>

#include "framework/core/spatial.hpp"
#include "nodes/physics/deformable/elastic_model.hpp"
#include "nodes/physics/deformable/sparse_factor.hpp"

namespace tactor {

struct BalanceOptions {
  double tolerance = 1e-9;  ///< of the residual force over the forces
  int most_steps = 200;
  FactorKind factor = FactorKind::automatic;
};

struct Balance {
  Eigen::VectorXd x;       ///< m, of all nodes
  bool converged = false;  ///< else x is where the search ended
  int steps = 0;           ///< Newton steps that were made
  double residual = 0;     ///< |f_elastic + f_outer| / (|f_elastic| + |f_outer|)
};

/// Positions at which elastic forces, weight and the forces `extra` (N, on the unknowns; empty: none) cancel, from
/// `start` (m, all nodes). A minimum of energy(x) - (weight + extra) . x by Newton's method with the projected Hessian
/// and a line search; near the end, where the energy's differences are rounding, a step counts that makes the residual
/// smaller. Not converged where nothing holds a body that something pulls.
Balance settle(const ElasticModel& model, const Eigen::VectorXd& start, const Vec3& gravity,
               const Eigen::VectorXd& extra = {}, const BalanceOptions& options = {});

}  // namespace tactor
