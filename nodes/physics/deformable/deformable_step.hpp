// One implicit step of deformable bodies together with the rigid bodies that touch them.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "nodes/physics/deformable/deformable_options.hpp"
#include "nodes/physics/deformable/node_equation.hpp"
#include "nodes/physics/deformable/patch_choice.hpp"
#include "nodes/physics/deformable/patch_step.hpp"
#include "nodes/physics/deformable/soft_scene.hpp"
#include "nodes/physics/deformable/step_contacts.hpp"
#include "nodes/physics/deformable/step_factor.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

/// What steps have taken so far.
struct DeformableCounts {
  std::int64_t steps = 0, iterations = 0, factors = 0, damped = 0, left_out = 0;
  std::int64_t updates = 0;   ///< of factors, by what iterations found out
  std::int64_t by_euler = 0;  ///< steps that the midpoint rule was to take
};

/// Advances x, the positions of the nodes, and the rigid bodies by h seconds. Implicit Euler, with all forces at the
/// end of the step:
///   M (v' - v) = h (f_elastic(x') + M g - D v' + S^T f),   x' = x + h v',   D = drag M + damping K,
/// f being the contact forces, which RigidStep has together with the rigid bodies' equations. By the midpoint rule the
/// same is solved over h / 2, and then x' = x + 2 (x_m - x), v' = 2 v_m - v. K in D is that of where the nodes would be
/// halfway at their velocities, warped (ElasticModel::Tangent), so that turning is not damped.
///
/// **Energy by the midpoint rule.** The force in the middle of the way does the work of linear forces exactly, but not
/// that of forces which bend on the way: energy goes up and down. What it loses is saved up, no more than a hundredth
/// of what the nodes store. A step that would take more than is saved is taken by implicit Euler instead, and so is one
/// that is not solved; both are counted. So energy never exceeds what there was plus the work of contacts.
///
/// **How it is solved.** About x_i, beginning with x, the equation is linear in the displacement d: A d = r + S^T f
/// with
///   A = M (1 / h^2 + drag / h) + K (1 + damping / h).
/// A is factored with the nodes of the patch (PatchChoice) last, so that its Schur complement on them is at hand. The
/// displacement without contact is d = A^-1 r. RigidStep then minimises one convex function of the rigid bodies'
/// velocities and those of the patch, in which the patch has the inertia h^2 Schur(A); at last d += A^-1 S^T f.
/// Contacts are found anew at each x_i, where the bodies are by then. Where the tool touches nothing at the start, the
/// first contacts are those that it meets first on its way without them, looked for at 16 places at most, so that a
/// fast tool does not pass through. The step is done when what is left of the equation at x' is below `tolerance` of
/// the forces on the nodes, or below what rounding x leaves. A displacement that does not lower
///   |x' - x - h v|_M^2 / (2 h^2) + E(x') + |x' - x|_D^2 / (2 h) - f . x'
/// is halved. Where the iterations do not do, the velocities are scaled so that the energy of the nodes is no larger
/// than before plus the work of contacts; this is counted as damped. No state is made that is not finite: all stay at
/// rest instead.
///
/// **Factors.** K costs an assembly and A a factorisation. With reuse_factors a factor of an earlier step serves, also
/// of one up to 15 % longer or shorter, and learns from each iteration (UpdatedFactor). Contacts see the same
/// compliance as the nodes, and what is left is judged by the forces as they are, so that an old factor costs
/// iterations and no accuracy. What it costs is added up from step to step: an iteration that leaves the share c of
/// what the factor was to solve wastes 1 - log c / log 0.1 of itself, because a factor of where the nodes are leaves
/// about a tenth. Where that comes to more than an assembly and a factorisation, as both are told by counts of
/// multiplications, A is factored anew: after one slow iteration or two for a small body, after many for a large one.
/// So it is where the iterations that are left would not do, and where a displacement had to be halved. Without
/// reuse_factors each step factors A, and again where an iteration leaves more than a third.
class DeformableStep {
 public:
  /// `model`: of the rigid bodies. `soft` and `tool` must outlive it.
  DeformableStep(const SoftScene& soft, SoftContacts& contacts, const ContactBody& tool, const SystemModel& model,
                 const DeformableOptions& options, const Vec3& gravity_W);

  DeformableStep(const DeformableStep&) = delete;
  DeformableStep& operator=(const DeformableStep&) = delete;

  /// Sets all nodes to these places (m) at rest.
  void place(const Eigen::VectorXd& x);
  /// And with these velocities (m/s) of the unknowns.
  void place(const Eigen::VectorXd& x, const Eigen::VectorXd& v);
  /// `before` and `device`: the handle at the start and the end of the step. `rigid`: the contacts of rigid bodies with
  /// each other. Contact wrench and counts of the result are those of all contacts of the tool.
  StepResult advance(const CouplingParameters& coupling, const DeviceState& before, const DeviceState& device,
                     const ContactPlanes& rigid, double h, BodyStates& bodies);

  [[nodiscard]] const SoftScene& soft() const { return soft_; }
  [[nodiscard]] const DeformableOptions& options() const { return options_; }
  [[nodiscard]] const SystemModel& model() const { return rigid_step_.model(); }
  [[nodiscard]] const Eigen::VectorXd& x() const { return x_; }  ///< m, of all nodes
  [[nodiscard]] const Eigen::VectorXd& v() const { return v_; }  ///< m/s, of the unknowns
  [[nodiscard]] const PatchChoice& patch() const { return patch_; }
  /// s, for how long the tool's way counts where the next patch is chosen.
  void set_patch_horizon(double horizon) { patch_.set_horizon(horizon); }
  [[nodiscard]] const DeformableCounts& counts() const { return counts_; }
  /// Brings the patch to where the last step ended. A step begins with it; who condenses the bodies onto it asks
  /// before, and the step then does not look again. The way of the tool counts for the horizon that was set last.
  void refresh(const BodyStates& bodies);
  /// So many iterations cost what an assembly and a factorisation do, by counts of multiplications. After a step.
  [[nodiscard]] double iterations_a_factor_is_worth() const { return factor_.iterations_it_is_worth(); }
  /// J, of all nodes: kinetic, elastic, and of weight.
  [[nodiscard]] double energy() const { return equation_.energy(x_, v_); }

  /// N, of elasticity and weight on the unknowns at x, as the last step left them.
  [[nodiscard]] const Eigen::VectorXd& inner_force() const { return equation_.inner_force(); }

 private:
  [[nodiscard]] bool by_midpoint(const CouplingParameters& coupling) const;
  bool factor(double h, ElasticModel::Tangent tangent);
  [[nodiscard]] double allowed(const Eigen::VectorXd& x) const;
  const Eigen::VectorXd& x_end(bool midpoint);
  void push();
  double halve_way(double was_left, double solved);
  bool solve(RigidStep& rigid_step, const StepInput& input, BodyStates& bodies, StepResult& result);
  double take(double h, bool midpoint);
  bool advance_by_midpoint(const StepInput& input, BodyStates& bodies, StepResult& result);
  [[nodiscard]] double stored() const { return equation_.stored(x_, v_); }
  [[nodiscard]] double energy_rounding(double work) const;
  void limit_energy(double before, double work);

  const SoftScene& soft_;
  DeformableOptions options_;
  RigidStep rigid_step_, euler_step_;
  PatchChoice patch_;
  StepContacts contacts_;
  NodeEquation equation_;
  StepFactor factor_;
  PatchStep patch_step_;
  Eigen::VectorXd x_, v_;
  double spare_ = 0;  // J, that steps of the midpoint rule have lost and not taken back
  DeformableCounts counts_;

  // Of an iteration.
  Eigen::VectorXd x_i_, x_next_, x_end_;    // m, of all nodes: before, after, and at the end of the step
  Eigen::VectorXd left_, without_contact_;  // N, of the equation, and that but for the contacts' force
  Eigen::VectorXd d_, pushed_;              // m, from x_i_ to x_next_, and what contacts add to it
};

}  // namespace tactor
