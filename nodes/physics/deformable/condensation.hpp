// Condenses deformable bodies onto the patch around the tool, for those who step it at each tick.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include "nodes/physics/deformable/deformable_step.hpp"
#include "nodes/physics/deformable/kept_mass.hpp"
#include "nodes/physics/deformable/master_choice.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"

namespace tactor {

/// Makes the LocalPatch of each result.
///
/// **Where.** On the masters (MasterChoice). Those far from the tool carry what the body does as a whole: its slow
/// motions are not shapes that the touched nodes give it in balance. Only nodes around the tool are told to readers.
///
/// **Stiffness.** K is the mean of the exact derivative of the forces, where the result has the nodes, and of the
/// warped one. The first foretells best how a body goes on, the second how it comes back; over the motions of a hand
/// the mean is off least. Where it is not positive definite, K is the warped one. With A(s) = Schur(K + s M), the Schur
/// complement on the masters, the other nodes are in balance at a harmonic motion of s = -w^2. K_r = A(0) is Guyan's
/// stiffness, and A'(0) is Guyan's mass, that of all that is carried along in slow motion (R. Guyan, AIAA Journal,
/// 1965). Both come from two small s, which also a body that nothing holds has, 1e-7 and 1e-6 of trace(K) / trace(M):
///   M_r = (A(s_1) - A(s_0)) / (s_1 - s_0),   K_r = A(s_0) - s_0 M_r.
/// A secant to s_1 = 1 / h^2, as the step itself sees it, has less mass and delivers worse: what matters is the motion
/// over some 30 ms. The mass costs a factor, so it is kept (KeptMass). Modes are those of K_r z = w^2 M_r z of each
/// body, with its damping drag + damping w^2. What the masters feel of a force r on all unknowns is K_r u on them, u =
/// K^-1 r: the force of each mode is shape^T of that of elasticity and weight where the result has the nodes, and its
/// rate is shape^T of that of the momentum M v.
class Condensation {
 public:
  /// `results`: how many patches are read at the same time. `step`, whose options count here too, must outlive it.
  Condensation(const DeformableStep& step, std::size_t results);

  /// The patch after the step's last `refresh`; empty where the tool is far from all that deforms. None where readers
  /// hold all arrays, or the stiffness or mass is not positive definite.
  std::optional<LocalPatch> condense();
  /// Factorisations so far: one a patch, and another where its mass is made.
  [[nodiscard]] std::int64_t factors() const { return factors_; }

 private:
  bool condense_at(double s, Eigen::MatrixXd& schur);
  bool make_modes();
  bool make_modes_by_body(double s0);
  void reduce(Eigen::MatrixXd& schur) const;
  [[nodiscard]] Eigen::VectorXd on_modes(const Eigen::VectorXd& force);
  [[nodiscard]] std::optional<LocalPatch> patch_of_modes();

  const DeformableStep& step_;
  MasterChoice choice_;
  std::unique_ptr<SparseFactor> factor_;
  std::int64_t factors_ = 0;
  Eigen::SparseMatrix<double> K_, A_;
  Eigen::VectorXd force_;          // N, elastic, which an assembly makes too
  Eigen::MatrixXd static_, slow_;  // A(s_0), A(s_1)
  KeptMass mass_;
  Eigen::MatrixXd shapes_;            // of the masters, a column a mode
  Eigen::VectorXd square_, damping_;  // by mode: w^2, 1/s
  Eigen::VectorXd solved_;
  ArrayPool<PatchNode> node_pool_;
  ArrayPool<PatchFace> face_pool_;
  ArrayPool<PatchMode> mode_pool_;
  ArrayPool<double> shape_pool_;
};

}  // namespace tactor
