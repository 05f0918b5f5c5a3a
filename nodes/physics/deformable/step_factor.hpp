// The factor of a step's equation, kept from step to step.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "nodes/physics/deformable/elastic_model.hpp"
#include "nodes/physics/deformable/updated_factor.hpp"

namespace tactor {

/// The factor of A = M (1 / h^2 + drag / h) + K (1 + damping / h), with some nodes eliminated last. It serves for
/// several steps, and counts what its slow iterations waste; DeformableStep says by which rule it is made anew.
class StepFactor {
 public:
  /// `model` must outlive it.
  StepFactor(const ElasticModel& model, FactorKind kind);

  /// From now on these nodes are eliminated last, as a SparseFactor numbers them; nothing is factored.
  void reorder(std::vector<int> last_nodes);
  /// Nothing is factored from now on.
  void forget() { h_ = 0; }
  /// Assembles K at x and factors A for a step of h seconds. False where that has no factor.
  bool factor(const Eigen::VectorXd& x, double h, ElasticModel::Tangent tangent);
  /// Whether what is factored may be used for a step of h seconds.
  [[nodiscard]] bool serves(double h) const;

  /// Whether to factor anew after an iteration that left the share `contraction` of what the factor was to solve, with
  /// `to_go` iterations left. `excess`: what is left over what may be. `fresh`: it is of this step.
  bool is_due(double contraction, double excess, int to_go, bool fresh);
  /// Learns from an iteration that left that share: the forces changed by y (N) over the way s (m). True where it did.
  bool learn(double contraction, const Eigen::VectorXd& s, const Eigen::VectorXd& y);

  /// b becomes A^-1 b.
  void solve(Eigen::VectorXd& b) const { factor_.solve(b); }
  /// N/m, the Schur complement of A on the last nodes.
  [[nodiscard]] const Eigen::MatrixXd& schur() const { return factor_.schur(); }
  /// N/m, the norm of A's diagonal.
  [[nodiscard]] double stiffest() const { return stiffest_; }
  /// So many iterations cost what an assembly and a factorisation do, by counts of multiplications.
  [[nodiscard]] double iterations_it_is_worth() const;

 private:
  const ElasticModel& model_;
  UpdatedFactor factor_;
  Eigen::SparseMatrix<double> K_, A_;
  Eigen::VectorXd force_;  // N, elastic, which an assembly makes too
  std::vector<int> last_nodes_;
  bool analysed_ = false;
  double h_ = 0;  // s, of what is factored; 0: nothing is
  double stiffest_ = 0;
  double wasted_ = 0;  // iterations, since the last factorisation
};

}  // namespace tactor
