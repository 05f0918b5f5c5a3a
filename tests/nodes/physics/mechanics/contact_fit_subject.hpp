// A ball on a wall that pushes in closed form, and a fit that is given results of it.
#pragma once

#include <cmath>
#include <limits>

#include "nodes/physics/mechanics/contact_fit.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"

namespace tactor::test::contact_fit {

inline constexpr double radius = 0.01;  // m, of the ball
inline constexpr double stick = 1e-4;   // m/s
inline constexpr double k = 2000, b = 3, depth = 1e-3;
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// A ball that is pressed into the wall x = 0, of which the model says k, b and `mu`.
struct Wall {
  double mu = 0.3;
  Vec3 v;  // m/s, of the ball
  double deep = depth;

  [[nodiscard]] BodyStates bodies() const { return one_body({radius - deep, 0, 0}, v); }
  [[nodiscard]] LocalContacts contacts() const { return wall_around({{radius - deep, 0, 0}}, k, b, mu); }
  /// Physics' force where the wall is `scale` times as stiff and damped, its friction `true_mu`, and all slides.
  [[nodiscard]] Wrench wrench(double scale, double true_mu) const {
    const double N = scale * (k * deep - b * v.x);
    const Vec3 along{0, v.y, v.z};
    const double speed = norm(along);
    const Vec3 force = Vec3{N, 0, 0} - (speed > 0 ? true_mu * N / speed : 0) * along;
    return {force, cross(Vec3{-radius, 0, 0}, force)};
  }
};

/// Gives results to a fit, each a period after the last.
class Subject {
 public:
  explicit Subject(bool rotates = false) : fit(rotates, stick) {}
  FitOutcome take(const LocalContacts& contacts, const BodyStates& bodies, const Wrench& wrench, int touching = 1) {
    time_.ns += 20'000'000;
    return fit.take(time_, contacts, bodies, false, wrench, touching);
  }
  FitOutcome take(const Wall& wall, const Wrench& wrench, int touching = 1) {
    return take(wall.contacts(), wall.bodies(), wrench, touching);
  }
  [[nodiscard]] double scale() const { return fit.error().stiffness_scale; }
  [[nodiscard]] double excess() const { return fit.error().friction_excess; }
  [[nodiscard]] Time time() const { return time_; }

  ContactFit fit;

 private:
  Time time_;
};

inline bool same(const ContactError& x, const ContactError& y) {
  return x.stiffness_scale == y.stiffness_scale && x.friction_excess == y.friction_excess;
}

}  // namespace tactor::test::contact_fit
