// What a contact plane does to the bodies that it is between, over a step that is solved.
#pragma once

#include <algorithm>
#include <cmath>

#include "nodes/physics/mechanics/eigen.hpp"
#include "nodes/physics/mechanics/lifting_contact.hpp"
#include "nodes/physics/mechanics/normal_force.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

/// The force of a plane by its relative velocity u, m/s: that at the end of the step by implicit Euler, the mean of the
/// step by the midpoint rule.
template <Integrator integrator>
class PlaneForces {
  using Matrix3d = Eigen::Matrix3d;
  using Vector3d = Eigen::Vector3d;
  using Plane = RigidStep::Plane;
  static constexpr bool midpoint = integrator == Integrator::midpoint;
  static constexpr double whole = midpoint ? 2 : 1;  // the step, in the time that is solved for

 public:
  /// m/s, up to which friction is viscous where a plane tells no creep.
  explicit PlaneForces(double stick_velocity) : stick_velocity_(stick_velocity) {}

  /// The force of a plane on its moving body at relative velocity u, with its friction bound, N.
  [[nodiscard]] Vec3 force(const Plane& p, const Vec3& u) const {
    if (p.coned) return lifting_force(p, u);
    const double normal = normal_at(p, dot(p.n, u)).force;
    if (normal == 0 && p.bound == 0) return {};
    return normal * p.n - rub(p, p.bound, slide(p, u).u_t);
  }

  /// The normal force at the plane's velocity, N.
  [[nodiscard]] double normal(const Plane& p) const {
    return p.coned ? lifting_at(p, p.u).normal : normal_at(p, dot(p.n, p.u)).force;
  }

  /// Sets S to what the force at the plane's velocity falls by with it, N s/m, symmetric; false where by nothing.
  bool slope(const Plane& p, Matrix3d& S) const {
    if (p.coned) return lifting_slope(p, S);
    const double normal = normal_at(p, dot(p.n, p.u)).slope;
    if (normal == 0 && p.bound == 0) return false;
    const auto [u_t, back] = slide(p, p.u);
    const double sliding = norm(u_t);
    const double stick = stick_velocity(p, p.bound);
    const double rough = whole * p.bound / std::max(sliding, stick);
    // Of no direction where it sticks.
    const Vec3 t = sliding > stick ? (1 / sliding) * u_t : Vec3{};
    for (int b = 0; b < 3; ++b) {
      for (int a = 0; a < 3; ++a) {
        S(a, b) = (normal - rough) * p.n[a] * p.n[b] - rough * t[a] * t[b] + (a == b ? rough : 0);
      }
    }
    if constexpr (midpoint) S -= rough * eigen(back) * eigen(back).transpose();
    return true;
  }

  /// The force that a plane has at the end of the step, given its velocity and its force for that. Of implicit Euler it
  /// is the same.
  [[nodiscard]] Vec3 force_at_end(const Plane& p) const {
    if constexpr (!midpoint) return p.force;
    const Vec3 u = velocity_at_end(p, p.u);
    const double lifted = p.coned ? p.lift * lifting_at(p, p.u).slip : p.lifted;
    const double more = p.carried + lifted - p.inertia * dot(p.n, p.u);
    const double normal =
        std::max(0.0, p.push - 2 * p.spring * dot(p.n, p.u) - (p.damping - p.inertia) * dot(p.n, u) + more);
    return normal * p.n - rub(p, p.friction * normal, across(p, u));
  }

  /// Changes the lift towards that of the velocity of now; returns how far it was off, N.
  double follow_lift(Plane& p) const {
    if (!p.coned) {
      const double before = p.lifted;
      p.lifted_below = p.lifted = p.lift * slip(p);
      return std::abs(p.lifted - before);
    }
    // By the secant of the last two iterations.
    const double told = (p.lift - p.friction * (p.spring + p.damping) / whole) * lifting_at(p, p.u).slip;
    const double off = told - p.lifted, change = p.lifted - p.lifted_before;
    if (off >= 0) p.lifted_below = p.lifted;
    const double slope = change == 0 ? 0 : std::clamp((told - p.told_before) / change, 0.0, 0.95);
    p.lifted_before = p.lifted;
    p.told_before = told;
    p.lifted += off / (1 - slope);
    return std::abs(off);
  }
  /// W, what the plane's force puts in beyond its spring and its inertia. Where these would pull, their energy is lost.
  [[nodiscard]] double power(const Plane& p) const {
    const double speed = dot(p.n, p.u);
    const double elastic = p.push + p.carried - (p.spring + p.inertia) * speed;
    return dot(p.force, p.u) - (speed > 0 ? std::max(0.0, elastic) : elastic) * speed;
  }

  /// N s/m, of friction where bodies overlap, if it is viscous.
  [[nodiscard]] double viscosity(const Plane& p) const {
    const double bound = p.friction * p.push;
    return bound / stick_velocity(p, bound);
  }

 private:
  [[nodiscard]] NormalForce normal_at(const Plane& p, double speed) const {
    return normal_force<integrator>(p.push, p.spring, p.damping, speed, p.carried + p.lifted);
  }
  [[nodiscard]] Vec3 velocity_at_end(const Plane& p, const Vec3& u) const {
    if constexpr (!midpoint) return u;
    return 2 * u - p.u_start;
  }
  [[nodiscard]] static Vec3 across(const Plane& p, const Vec3& u) { return u - dot(p.n, u) * p.n; }
  /// The velocity that friction goes with, and the unit direction in which it does not feel u, where there is one.
  struct Slide {
    Vec3 u_t, back;
  };
  /// At velocity u: that at the end of the step, less what of it lies between rest and the start's reversed. Within
  /// those the bodies have turned back during the step, and the whole way went with the start.
  [[nodiscard]] Slide slide(const Plane& p, const Vec3& u) const {
    const Vec3 end = across(p, velocity_at_end(p, u));
    if constexpr (!midpoint) return {end, {}};
    const Vec3 start = across(p, p.u_start);
    const double along = dot(end, start), square = dot(start, start);
    if (along >= 0) return {end, {}};
    if (along <= -square) return {end + start, {}};
    return {end - (along / square) * start, (1 / std::sqrt(square)) * start};
  }
  /// The speed up to which friction of that bound is viscous.
  [[nodiscard]] double stick_velocity(const Plane& p, double bound) const {
    return std::max(stick_velocity_, p.creep * bound);
  }
  /// What friction of that bound takes at sliding velocity u_t.
  [[nodiscard]] Vec3 rub(const Plane& p, double bound, const Vec3& u_t) const {
    return (bound / std::max(norm(u_t), stick_velocity(p, bound))) * u_t;
  }

  /// m/s, how fast a plane that is not coned slides beyond the creep, with the lift that this gives.
  [[nodiscard]] double slip(const Plane& p) const {
    const double speed = norm(slide(p, p.u).u_t), give = p.creep * p.friction;
    const double push = normal(p);
    const double alone = push > 0 ? push - p.lifted : -p.lift * speed;
    const double with_lift = std::max(0.0, (alone + p.lift * speed) / (1 + p.lift * give));
    return std::max(0.0, speed - stick_velocity(p, p.friction * with_lift));
  }
  [[nodiscard]] LiftingContact lifting(const Plane& p) const {
    return {.push = p.push + p.carried + p.lifted,
            .slope = p.spring + p.damping,
            .friction = p.friction,
            // Until a bound is known, as of 1 N.
            .creep = p.bound > 0 ? stick_velocity(p, p.bound) / p.bound : stick_velocity(p, 1),
            .share = 1 / whole};
  }
  [[nodiscard]] LiftingContact::At lifting_at(const Plane& p, const Vec3& u) const {
    return lifting(p).at(dot(p.n, u), norm(slide(p, u).u_t));
  }
  [[nodiscard]] Vec3 lifting_force(const Plane& p, const Vec3& u) const {
    const LiftingContact contact = lifting(p);
    const Vec3 u_t = slide(p, u).u_t;
    const double speed = norm(u_t);
    const auto at = contact.at(dot(p.n, u), speed);
    if (at.normal == 0) return {};
    return at.normal * p.n - (at.slip > 0 ? p.friction * at.normal / speed : 1 / contact.creep) * u_t;
  }
  bool lifting_slope(const Plane& p, Matrix3d& S) const {
    const LiftingContact contact = lifting(p);
    const auto [u_t, back] = slide(p, p.u);
    const double speed = norm(u_t);
    const auto at = contact.at(dot(p.n, p.u), speed);
    if (at.normal == 0) return false;
    const bool slips = at.slip > 0;
    const double rough = whole * (slips ? p.friction * at.normal / speed : 1 / contact.creep);
    const Vector3d n = eigen(p.n), t = slips ? Vector3d(eigen(u_t) / speed) : Vector3d(Vector3d::Zero());
    const Vector3d along = n - p.friction * t;
    S = (contact.slope / at.stretch) * along * along.transpose() -
        rough * (n * n.transpose() + t * t.transpose() + eigen(back) * eigen(back).transpose());
    S.diagonal().array() += rough;
    return true;
  }

  double stick_velocity_;
};

}  // namespace tactor
