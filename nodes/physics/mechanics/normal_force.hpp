// How hard a contact pushes along its normal over a step, by each integrator.
#pragma once

#include "nodes/physics/mechanics/system.hpp"

namespace tactor {

/// A normal force, and how it falls with the velocity along the normal.
struct NormalForce {
  double force = 0;  ///< N
  double slope = 0;  ///< N s/m
};

namespace normal_force_parts {

/// The force that takes out of a spring what it stores on the way from `push` to `end`, the forces (N) that it would
/// have there if it also pulled: with V(q) = max(0, q)^2 / 2 it is (V(push) - V(end)) / (push - end). The slope is by
/// -end / 2.
inline NormalForce secant(double push, double end) {
  if (push > 0 && end > 0) return {(push + end) / 2, 1};
  if (push > 0) {
    const double share = push / (push - end);
    return {push / 2 * share, share * share};
  }
  if (end > 0) {
    const double share = end / (end - push);
    return {end / 2 * share, share * (2 - share)};
  }
  return {};
}

}  // namespace normal_force_parts

/// The force at velocity `speed` (m/s, along the normal, positive where the bodies part), from
///   push = -k phi, N, with phi the distance at the start,   spring = k h, N s/m,   damping = b, N s/m,
/// and a force `more`, N, that does not depend on the velocity.
/// Implicit Euler, `speed` being that at the end of the step of h seconds:
///   N = max(0, push - (spring + damping) speed + more).
/// Midpoint, `speed` being the mean of the step of 2 h seconds, at whose end the spring has push' = push - 2 spring
/// speed:
///   N = max(0, G - damping speed + more)                       where push > 0,
///   N = max(G, (push + push') / 2 - damping speed + more)      else,
/// with G the secant force, so that without damping the spring stores exactly the work that N takes, also where contact
/// begins or ends within the step, and with damping energy is taken out (O. Gonzalez, "Time integration and discrete
/// Hamiltonian systems", 1996; T. Laursen, V. Chawla, "Design of energy conserving algorithms for frictionless dynamic
/// contact problems", 1997). Both fall with `speed` without a step, so that they are the slope of a convex function.
template <Integrator integrator>
NormalForce normal_force(double push, double spring, double damping, double speed, double more = 0) {
  if constexpr (integrator == Integrator::implicit_euler) {
    const double slope = spring + damping, force = push - slope * speed + more;
    return force > 0 ? NormalForce{force, slope} : NormalForce{};
  }
  const double end = push - 2 * spring * speed;
  NormalForce N = normal_force_parts::secant(push, end);
  N.slope *= spring;
  if (push > 0) {
    N.force = N.force - damping * speed + more;
    N.slope += damping;
    return N.force > 0 ? N : NormalForce{};
  }
  const double damped = (push + end) / 2 - damping * speed + more;
  return damped > N.force ? NormalForce{damped, spring + damping} : N;
}

}  // namespace tactor
