// How one step is solved: Newton's method with a line search, else one damped linear step. Instantiated for each
// number of degrees of freedom in a file of its own, because each takes long to compile.
#pragma once

#include <cmath>
#include <span>

#include <Eigen/Cholesky>

#include "nodes/physics/contact/moved_on.hpp"
#include "nodes/physics/mechanics/step_equations.hpp"

namespace tactor {

namespace step_solve {

inline constexpr int following = 12;        // iterations in which the bounds may follow
inline constexpr int following_lifts = 20;  // and where sliding lifts
inline constexpr int searches = 40;         // evaluations along a line, at most

/// The a in (0, 1] at which `slope`, increasing and negative at 0, has all but vanished.
template <class Slope>
double line_search(const Slope& slope, double at_zero) {
  double at_one = slope(1);
  // A full step that stops short of the minimum is taken: the next one goes on from there.
  if (at_one <= -0.1 * at_zero) return 1;
  double low = 0, high = 1, at_low = at_zero, at_high = at_one;
  for (int i = 0; i < searches; ++i) {
    // The false position, or the middle where it moves little (Illinois).
    const double a = low + (high - low) * at_low / (at_low - at_high);
    const double value = slope(a);
    if (std::abs(value) <= -0.1 * at_zero || !(a > low && a < high)) return a;
    if (value < 0) {
      low = a, at_low = value;
      at_high /= 2;
    } else {
      high = a, at_high = value;
      at_low /= 2;
    }
  }
  return low > 0 ? low : high;
}

/// Newton's method from the velocities of now. Returns the iterations, or -1 where they did not do.
template <class E>
int newton(E& equations, int most, typename E::Vector& v, double* workspace) {
  v = equations.start();
  if (E::midpoint || equations.carries()) equations.set_velocities(v, &RigidStep::Plane::u_start);
  if (equations.carries()) equations.carry();
  equations.set_velocities(v, &RigidStep::Plane::u);
  bool held = false;
  typename E::Vector left;
  auto H = equations.matrix(workspace);
  int most_following = equations.lifts() ? following_lifts : following;
  for (int i = 0; i < most; ++i) {
    if (!held) {
      held = equations.follow();
      if (!held && i >= most_following) {
        held = true;
        equations.hold_lifts();
      }
    }
    equations.residual(v, left);
    if (equations.met(left)) {
      if (!equations.lifts() || !equations.drop_lifts()) return i;
      held = false;
      most_following = i + following;
      continue;
    }
    equations.derivative(H, equations.newton());
    const Eigen::LLT<Eigen::Ref<typename E::Matrix>> factors(H);
    if (factors.info() != Eigen::Success) return -1;
    // In place: a solution of its own would be on the heap where there is a patch.
    typename E::Vector d = left;
    factors.solveInPlace(d);
    d = -d;
    const double decrement = -d.dot(left);
    if (!std::isfinite(decrement)) return -1;
    equations.set_velocities(d, &RigidStep::Plane::du);
    const double a = line_search(typename E::Line(equations, v, d), -decrement);
    v += a * d;
    equations.set_velocities(v, &RigidStep::Plane::u);
  }
  return -1;
}

}  // namespace step_solve

template <int Dofs, Integrator integrator, int Nodes>
StepResult RigidStep::solve(const CouplingParameters& coupling, const DeviceState& device,
                            const ContactPlanes& contacts, double h, BodyStates& bodies, const SoftPatch* patch,
                            SoftPatchMotion* motion) {
  using E = StepEquations<Dofs, integrator, Nodes>;
  std::span<Plane> planes;
  if constexpr (E::midpoint) {
    const BodyStates ahead = moved_on(bodies, h);
    planes = prepare_planes(bodies, &ahead, false, contacts, h, patch);
  } else {
    planes = prepare_planes(bodies, nullptr, coupling.massless != 0, contacts, h, patch);
  }
  StepResult result;
  const std::size_t known = contacts.planes.size() + (patch == nullptr ? 0 : patch->contacts.size());
  result.left_out = static_cast<int>(known - planes.size());

  const BodyStates before = bodies;
  E equations(model_, coupling, device, h, before, planes, patch);
  typename E::Vector v;
  result.iterations = step_solve::newton(equations, model_.iterations, v, matrix_.data());
  result.outcome = StepOutcome::converged;
  if (result.iterations < 0) {
    result.iterations = model_.iterations;
    result.outcome = Nodes > 0 ? StepOutcome::stopped : StepOutcome::damped;
    if constexpr (Nodes > 0) return result;
    // The caller takes a step of implicit Euler instead.
    if constexpr (E::midpoint) return result;
    v.setZero(equations.dofs());
    equations.set_velocities(v, &RigidStep::Plane::u);
    typename E::Vector left;
    auto H = equations.matrix(matrix_.data());
    equations.damped_residual(v, left);
    equations.derivative(H, equations.damped());
    const Eigen::LLT<Eigen::Ref<typename E::Matrix>> factors(H);
    if (factors.info() != Eigen::Success) {
      result.outcome = StepOutcome::stopped;
      return result;
    }
    v = -factors.solve(left);
    equations.set_velocities(v, &RigidStep::Plane::u);
    equations.damped_residual(v, left);
  }
  if constexpr (Nodes > 0) equations.finish_patch(v, *motion);
  result.turn = equations.finish(v, bodies);
  for (const Plane& p : planes) {
    if (p.body != 0 && p.other != 0) continue;
    const Vec3 force = equations.force_at_end(p);
    if (force == Vec3{}) continue;
    const double sign = p.body == 0 ? 1 : -1;
    ++result.touching;
    result.contact_T_W.force += sign * force;
    result.contact_T_W.torque += cross(p.body == 0 ? p.r_body : p.r_other, sign * force);
  }
  return result;
}

}  // namespace tactor
