// Condenses deformable bodies onto the patch around the tool, for those who step it at each tick.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "nodes/physics/deformable/deformable_step.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"

namespace tactor {

/// Makes the LocalPatch of each result.
///
/// With A(s) = Schur(K + s M), the Schur complement on the nodes of the patch, the other nodes are in balance at a
/// harmonic motion of s = -w^2. K_r = A(0) is Guyan's stiffness; a mass is taken by the secant
///   M_r = (A(s_1) - A(s_0)) / (s_1 - s_0),   K_r = A(s_0) - s_0 M_r,
/// so that the patch resists as the whole body does both in balance (s_0, all but 0, so that bodies which nothing holds
/// have one too) and as the step itself sees it (s_1 = 1 / h^2). A(s_1) comes with the step's own factor and A(s_0)
/// takes a second one; both serve as long as the step's does. Modes are those of K_r z = w^2 M_r z, with the damping
/// drag + damping w^2 of each; what damping bodies of different ones exchange by the patch is left out.
/// The force of each mode is that of elasticity and weight, r, where the result has the nodes: shape^T K_r u on the
/// patch, u = K^-1 r. Its rate is that of the nodes: sum_i shape_i rate_i = v on the patch. (That of the body's
/// momentum would be too large by what the body has of mass beyond M_r.)
class Condensation {
 public:
  /// `results`: how many patches are read at the same time. `step` must outlive it.
  Condensation(const DeformableStep& step, FactorKind factor, std::size_t results);

  /// The patch after the last step; empty where the tool is far from all that deforms. None where readers hold all
  /// arrays, or the mass matrix is not positive definite.
  std::optional<LocalPatch> condense();
  /// Second factors, so far.
  [[nodiscard]] std::int64_t factors() const { return factors_; }

 private:
  void choose_nodes();
  bool make_modes();
  void reduce(Eigen::MatrixXd& schur) const;
  void balanced(const Eigen::VectorXd& force, Eigen::VectorXd& on_patch);

  const DeformableStep& step_;
  std::unique_ptr<SparseFactor> factor_;
  Eigen::SparseMatrix<double> A_;
  std::vector<int> patch_;     // as it was analysed: all nodes that are eliminated last
  std::int64_t made_of_ = -1;  // the step's factors, when the modes were made
  std::int64_t factors_ = 0;
  std::vector<int> nodes_;  // of the message: around the tool, then those that do not move
  std::size_t free_ = 0;    // of them
  std::vector<PatchFace> faces_;
  Eigen::MatrixXd static_, dynamic_, mass_, shapes_;
  Eigen::VectorXd square_, damping_;  // by mode: w^2, 1/s
  Eigen::VectorXd solved_;
  SharedArray<double> sent_shapes_;
  SharedArray<PatchFace> sent_faces_;
  ArrayPool<PatchNode> node_pool_;
  ArrayPool<PatchFace> face_pool_;
  ArrayPool<PatchMode> mode_pool_;
  ArrayPool<double> shape_pool_;
};

}  // namespace tactor
