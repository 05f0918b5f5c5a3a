// Condenses deformable bodies onto the patch around the tool, for those who step it at each tick.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "nodes/physics/deformable/deformable_step.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"

namespace tactor {

/// Makes the LocalPatch of each result.
///
/// **Where.** The masters are the nodes around the tool (PatchChoice) and a few far from it (spread_nodes), which carry
/// what the body does as a whole: its slow motions are not shapes that the touched nodes give it in balance. Only nodes
/// around the tool are told to readers.
///
/// **Stiffness.** K is the mean of the exact derivative of the forces, where the result has the nodes, and of the
/// warped one. The first foretells best how a body goes on, the second how it comes back; over the motions of a hand
/// the mean is off least. Where it is not positive definite, K is the warped one. With A(s) = Schur(K + s M), the Schur
/// complement on the masters, the other nodes are in balance at a harmonic motion of s = -w^2. K_r = A(0) is Guyan's
/// stiffness, and A'(0) is Guyan's mass, that of all that is carried along in slow motion (R. Guyan, AIAA Journal,
/// 1965). Both come from two small s, which also a body that nothing holds has, 1e-7 and 1e-6 of trace(K) / trace(M):
///   M_r = (A(s_1) - A(s_0)) / (s_1 - s_0),   K_r = A(s_0) - s_0 M_r.
/// A secant to s_1 = 1 / h^2, as the step itself sees it, has less mass and delivers worse: what matters is the motion
/// over some 30 ms. The mass costs a factor, so it is kept: it turns with the masters of each body, as long as they
/// stay the same and have moved by no more than a tenth of how far they reach but for turning. Modes are those of K_r z
/// = w^2 M_r z of each body, with its damping drag + damping w^2. What the masters feel of a force r on all unknowns is
/// K_r u on them, u = K^-1 r: the force of each mode is shape^T of that of elasticity and weight where the result has
/// the nodes, and its rate is shape^T of that of the momentum M v.
class Condensation {
 public:
  /// `far_nodes`: masters far from the tool, at most. `results`: how many patches are read at the same time. `step`
  /// must outlive it.
  Condensation(const DeformableStep& step, FactorKind factor, int far_nodes, std::size_t results);

  /// The patch after the step's last `refresh`; empty where the tool is far from all that deforms. None where readers
  /// hold all arrays, or the stiffness or mass is not positive definite.
  std::optional<LocalPatch> condense();
  /// Factorisations so far: one a patch, and another where its mass is made.
  [[nodiscard]] std::int64_t factors() const { return factors_; }

 private:
  void choose_nodes();
  void choose_far_nodes();
  bool condense_at(double s, Eigen::MatrixXd& schur);
  [[nodiscard]] std::vector<int> last_nodes() const;
  [[nodiscard]] std::vector<Eigen::Index> masters_of(std::size_t body) const;
  [[nodiscard]] std::optional<Eigen::Matrix3d> turn_of(std::span<const Eigen::Index> own) const;
  bool turn_mass();
  bool make_modes();
  bool make_modes_by_body(double s0);
  void reduce(Eigen::MatrixXd& schur) const;
  void balanced(const Eigen::VectorXd& force, Eigen::VectorXd& on_masters);

  const DeformableStep& step_;
  std::unique_ptr<SparseFactor> factor_;
  std::size_t most_far_;
  std::vector<std::vector<int>> spread_;  // of each body
  Eigen::SparseMatrix<double> K_, A_;
  Eigen::VectorXd scratch_;
  std::vector<int> patch_;  // the step's, as it was analysed
  bool is_analysed_ = false;
  std::int64_t factors_ = 0;
  std::vector<int> nodes_;    // of the message: around the tool, then those that do not move
  std::size_t free_ = 0;      // of them
  std::vector<int> masters_;  // far from the tool, then around it
  std::vector<PatchFace> faces_;
  Eigen::MatrixXd static_, slow_, mass_, made_mass_, shapes_;  // static_: A(s_0), slow_: A(s_1)
  Eigen::VectorXd square_, damping_;                           // by mode: w^2, 1/s
  std::vector<int> mass_masters_;                              // whose mass_ it is
  Eigen::VectorXd mass_x_;                                     // m, where all nodes were then
  Eigen::VectorXd solved_;
  ArrayPool<PatchNode> node_pool_;
  ArrayPool<PatchFace> face_pool_;
  ArrayPool<PatchMode> mode_pool_;
  ArrayPool<double> shape_pool_;
};

}  // namespace tactor
