#include "devices/simulated/friction.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

Friction::Friction(const FrictionParameters& parameters)
    : parameters_(parameters), falls_(parameters.breakaway > parameters.coulomb && parameters.stribeck_velocity > 0) {}

double Friction::level(double speed) const noexcept {
  if (!falls_) return parameters_.coulomb;
  const double ratio = speed / parameters_.stribeck_velocity;
  return parameters_.coulomb + (parameters_.breakaway - parameters_.coulomb) * std::exp(-ratio * ratio);
}

Vec3 Friction::slowed(const Vec3& v, double h, double inertia) const noexcept {
  const double speed = norm(v);
  double force = parameters_.coulomb;
  if (falls_) force = level(std::max(speed - 0.5 * h * level(speed) / inertia, 0.0));
  const double loss = h * force / inertia;
  return speed <= loss ? Vec3{} : (1.0 - loss / speed) * v;
}

}  // namespace tactor
