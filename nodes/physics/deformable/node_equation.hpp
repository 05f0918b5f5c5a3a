// The equation of the nodes of deformable bodies over a step, and their energy.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "nodes/physics/deformable/elastic_model.hpp"

namespace tactor {

/// What is left at x (m, of all nodes) of the implicit equation from x0 and v0 over h seconds, N on the unknowns:
///   f_elastic(x) + M g - M (x - x0 - h v0) / h^2 - D (x - x0) / h + f,   D = drag M + damping K,
/// f being the contact forces. K in D is warped (ElasticModel::Tangent). Allocates nothing once a step was begun.
class NodeEquation {
 public:
  /// `model` must outlive it.
  NodeEquation(const ElasticModel& model, const Vec3& gravity_W);

  /// Begins a step of h seconds at x with velocities v (m/s, of the unknowns). K in D is that of where the nodes would
  /// be halfway.
  void begin(const Eigen::VectorXd& x, const Eigen::VectorXd& v, double h);
  [[nodiscard]] const Eigen::VectorXd& x0() const { return x0_; }
  [[nodiscard]] const Eigen::VectorXd& v0() const { return v0_; }
  /// N, on the unknowns: f, which contacts set.
  [[nodiscard]] Eigen::VectorXd& contact_force() { return contact_force_; }

  /// Sets `left` to what is left at x over h seconds.
  void residual(const Eigen::VectorXd& x, double h, Eigen::VectorXd& left);
  /// N, the sum of the norms of the forces that the last residual was made of.
  [[nodiscard]] double forces() const;
  /// J, the function of x whose slope is minus the residual, but for a constant.
  [[nodiscard]] double merit(const Eigen::VectorXd& x, double h);
  /// m, of the unknowns from x0 to x. Valid until the next call of another function.
  const Eigen::VectorXd& way_to(const Eigen::VectorXd& x);
  /// N, of elasticity and weight at x. Not computed anew where x is that of the last call or residual.
  const Eigen::VectorXd& inner_force(const Eigen::VectorXd& x);
  /// N, as it was computed last.
  [[nodiscard]] const Eigen::VectorXd& inner_force() const { return force_; }

  [[nodiscard]] double kinetic(const Eigen::VectorXd& v) const;                           ///< J
  [[nodiscard]] double stored(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const;  ///< J, kinetic and elastic
  /// J, that and of weight.
  [[nodiscard]] double energy(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const;

 private:
  void by_unknown(const Eigen::VectorXd& x, Eigen::VectorXd& values) const;
  void damp(const Eigen::VectorXd& way, Eigen::VectorXd& sum);

  const ElasticModel& model_;
  Eigen::VectorXd weight_;  // N
  Eigen::SparseMatrix<double> damping_K_;
  Eigen::VectorXd x0_, v0_;
  Eigen::VectorXd force_, x_force_;                               // N, of elasticity and weight, at x_force_
  Eigen::VectorXd inertia_force_, damper_force_, contact_force_;  // N
  Eigen::VectorXd way_, scratch_, product_;                       // by unknown
  Eigen::VectorXd halfway_;                                       // m, of all nodes
};

}  // namespace tactor
