// One implicit step of rigid bodies that touch contact planes, the first of them on the coupling.
#pragma once

#include <array>
#include <vector>

#include "nodes/physics/mechanics/soft_patch.hpp"
#include "nodes/physics/mechanics/system.hpp"

namespace tactor {

/// How a step was solved.
enum class StepOutcome : std::uint8_t {
  converged,
  damped,   ///< not within the iterations: the linear step below was taken
  stopped,  ///< nor could that be taken: all bodies keep their poses at rest
};

/// What a step found besides the new state.
struct StepResult {
  StepOutcome outcome = StepOutcome::stopped;
  Wrench contact_T_W;  ///< N, N m: of the contacts on the tool about its origin, at the end of the step
  int touching = 0;    ///< contacts of the tool with a force
  int left_out = 0;    ///< planes that were not usable (see `usable`)
  double work = 0;     ///< J, what the handle put in (see handle_work)
  int iterations = 0;  ///< of Newton's method
  double turn = 0;     ///< rad, the farthest that a body has turned
};

/// Advances the bodies by h seconds, by implicit Euler or the midpoint rule (SystemModel::integrator).
///
/// **Implicit Euler.** The equations, in momenta, with forces at the end of the step:
///   m (v' - v) = h (m g + F_coupling + sum f),     p' = p + h v',
///   L' - L     = h (tau_coupling + sum r x f),     R' = exp(h (w' - w*)) R*,     L' = I_W(R') w'',
/// where (R*, w*) is what free_rotation gives, so that a body without torque keeps its angular momentum and its kinetic
/// energy to rounding. The coupling acts on the tool alone, with the handle (p_WD, R_WD, v_WD, w_WD) at the end of the
/// step and without limits:
///   F = k_t (p_WD - p') + b_t (v_WD - v'),   tau = k_r (log(R_WD R^T) - h w') + b_r (w_WD - w').
/// A contact at lever r from each body's origin, with the bodies' relative velocity u there and the distance phi at
/// the start of the step:
///   N = max(0, -k (phi + h n . u) - b n . u),     f = N n - mu N u_t / max(|u_t|, stick_velocity),
/// with k = stiffness * weight, b = damping * weight. The damper meets a point that approaches at speed u from b u / k
/// above the surface on, so that the force has no step at the surface. Both bodies of a pair get the force at the same
/// point, hence linear and angular momentum of free bodies are kept to rounding. With coupling.massless the tool has no
/// inertia, no weight and no damper, nor have its contacts: it goes where springs balance, and w'' = w'.
///
/// A contact may tell more of its law. With u_0 the velocity u before the step, m_c = inertia * weight and
/// c = creep / weight it has
///   N = max(0, -k (phi + h n . u) - b n . u - m_c n . (u - u_0) / h + lift mu b s),   s = max(0, |u_t| - c mu N),
///   f = N n - mu N u_t / max(|u_t|, stick_velocity, c mu N).
/// Terms of m_c and s act where phi < 0 alone, and so does b where m_c > 0: the mass would else press from afar.
/// The contact's inertia holds the energy m_c (n . u)^2 / 2, which comes with the velocity that it begins with and is
/// lost where it ends; but for that energy no contact feeds any in.
///
/// Of a spring and a mass of angular frequency W a step keeps the share 1 / (1 + (W h)^2) of the energy.
///
/// **Midpoint.** The same equations, solved over h/2, with the handle in the middle of its way and the levers where the
/// bodies would be by then without forces. The velocities found are the means over the step; with them
///   p' = p + h v_m,     v' = v + 2 (v_m - v),     R' = exp(h (w_m - w*)) R*(h),     L' = L + 2 (L_m - L).
/// The coupling's spring and damper are those of the middle, the contacts' normal force is that of normal_force. So
/// springs give back what they take, also where contact begins or ends within the step, and the error is of second
/// order (J. Simo, N. Tarnow, "The discrete energy-momentum method", 1992). Friction goes with the velocity u_t at the
/// end of the step, so that what sticks comes to rest in one step; with the mean velocity it would go to and fro for
/// ever. What of u_t lies between zero and the reverse of the start's is left out, so that friction takes energy out
/// also where sliding turns back within the step. What is faster than the step is not damped but alternates from step
/// to step. A step that is not solved is taken by implicit Euler, and so is one with coupling.massless.
///
/// With friction bounds mu N held, the equations are the minimum of a convex function of the velocities, which Newton's
/// method with line search looks for (A. Castro, F. Permenter, X. Han, "An unconstrained convex formulation of
/// compliant contact", IEEE T-RO 2022; A. Castro, X. Han, J. Masterjohn, "Irrotational contact fields", 2023). The
/// bounds follow the normal forces in the first iterations, and are held then: however far they are off, friction
/// takes energy out. The force that s gives is held likewise. It is converged when what is
/// left of each body's equation is below model.tolerance of the sum of the norms of its terms. If it is not, one linear
/// step is taken instead, with all planes that overlap as springs and dampers of both signs and the friction viscous,
/// if total energy is then no larger than before plus the handle's work; else the bodies stay at rest where they are.
/// No state is ever made that is not finite. Throws nothing, allocates nothing.
///
/// **With a patch** of deforming surfaces the velocities of its nodes are unknowns too, and the convex function has the
/// term |u - u_free|^2 / 2 in the patch's inertia. The contact point of a face moves with the shares of its nodes. A
/// step that is not converged leaves all at rest.
class RigidStep {
 public:
  /// `patch_nodes`: the most that a patch will have.
  explicit RigidStep(const SystemModel& model, int patch_nodes = 0);
  [[nodiscard]] const SystemModel& model() const { return model_; }

  /// `before` and `device`: the handle at the start and the end of the step.
  StepResult advance(const CouplingParameters& coupling, const DeviceState& before, const DeviceState& device,
                     const ContactPlanes& contacts, double h, BodyStates& bodies);
  /// The most nodes of a patch.
  static constexpr int most_patch_nodes = 96;
  /// The same with a patch, of no more nodes than the constructor was told. Nothing is halved here, however far a body
  /// turns.
  StepResult advance(const SoftPatch& patch, const CouplingParameters& coupling, const DeviceState& before,
                     const DeviceState& device, const ContactPlanes& contacts, double h, BodyStates& bodies,
                     SoftPatchMotion motion);

  /// A contact plane as a step sees it.
  struct Plane {
    static constexpr int on_patch = -2;
    int body = 0, other = 0;        // -1 for what does not move
    std::array<int, 3> node{};      // of the patch, where `other` is on it
    std::array<double, 3> share{};  // of these
    Vec3 r_body, r_other;           // m, levers
    Vec3 n;
    double push = 0;      // N, the normal force at zero velocity; negative where apart
    double spring = 0;    // N s/m, stiffness times the time that is solved for
    double damping = 0;   // N s/m, along the normal, `inertia` included
    double inertia = 0;   // N s/m, the contact's inertia over the time that is solved for
    double friction = 0;  // Coulomb coefficient
    double bound = 0;     // N, friction force while sliding
    double creep = 0;     // m/s per N, of static friction
    double lift = 0;      // N s/m, normal force by the speed of sliding beyond the creep
    double carried = 0;   // N, of the inertia at zero velocity
    bool coned = false;   // whether lift and friction are those of LiftingContact
    double lifted = 0;    // N, of sliding; if coned, what it adds beyond LiftingContact
    // N, the same an iteration ago, what it should have been then, and the last that was too small.
    double lifted_before = 0, told_before = 0, lifted_below = 0;
    Vec3 u, du;    // m/s, relative velocity, and its change along the line that is searched
    Vec3 u_start;  // m/s, relative velocity at the start
    Vec3 force;    // N, on `body`
  };

 private:
  StepResult advance(const CouplingParameters& coupling, const DeviceState& before, const DeviceState& device,
                     const ContactPlanes& contacts, double h, int halvings, BodyStates& bodies);
  StepResult advance_once(const CouplingParameters& coupling, const DeviceState& before, const DeviceState& device,
                          const ContactPlanes& contacts, double h, BodyStates& bodies);
  template <Integrator integrator>
  StepResult solve_by(const CouplingParameters& coupling, const DeviceState& device, const ContactPlanes& contacts,
                      double h, BodyStates& bodies);
  template <int Dofs, Integrator integrator, int Nodes = 0>
  StepResult solve(const CouplingParameters& coupling, const DeviceState& device, const ContactPlanes& contacts,
                   double h, BodyStates& bodies, const SoftPatch* patch = nullptr, SoftPatchMotion* motion = nullptr);
  std::span<Plane> prepare_planes(const BodyStates& bodies, const BodyStates* ahead, bool massless,
                                  const ContactPlanes& contacts, double h, const SoftPatch* patch = nullptr);
  static void set_law(Plane& plane, const Contact& contact, double distance, bool massless, double h);
  std::size_t add_soft_planes(const BodyStates& at, const BodyStates& bodies, bool massless, const SoftPatch& patch,
                              double h, std::size_t count);

  SystemModel model_;
  std::array<Plane, 2 * ContactSet::capacity> planes_;
  std::vector<double> matrix_;  // of the equations with a patch
};

}  // namespace tactor
