#include "nodes/physics/mechanics/system.hpp"

#include <cmath>

namespace tactor {

ContactPlanes contact_planes(const ContactSet& set) {
  const auto count = static_cast<std::size_t>(set.count);
  return {std::span(set.bodies.X_WB).first(static_cast<std::size_t>(set.bodies.count)),
          std::span(set.contact).first(count), std::span(set.pair).first(count)};
}

bool usable(const ContactPlanes& contacts, std::size_t i, int bodies) {
  const Contact& c = contacts.planes[i];
  const ContactPair& pair = contacts.pairs[i];
  const int known = std::min(bodies, static_cast<int>(contacts.X_WB.size()));
  const bool paired = pair.body >= 0 && pair.body < known && pair.other < known && pair.other != pair.body &&
                      (pair.other >= 0 || pair.other == ContactPair::fixed);
  // A comparison with NaN is false.
  return paired && is_finite(c.p_TC) && is_finite(c.n_W) && std::isfinite(c.distance) && c.weight >= 0 &&
         c.stiffness >= 0 && c.damping >= 0 && c.friction >= 0 && std::isfinite(c.weight * c.stiffness) &&
         std::isfinite(c.weight * c.damping) && std::isfinite(c.friction) && c.inertia >= 0 && c.creep >= 0 &&
         c.lift >= 0 && c.lift <= 1 && std::isfinite(c.weight * c.inertia) && std::isfinite(c.creep);
}

Vec3 relative_velocity(const BodyStates& bodies, const ContactPair& pair, const Vec3& p_W) {
  const auto velocity = [&](std::int32_t i) {
    if (i == ContactPair::fixed) return Vec3{};
    const auto body = static_cast<std::size_t>(i);
    return bodies.V_WB[body].v + cross(bodies.V_WB[body].w, p_W - bodies.X_WB[body].p);
  };
  return velocity(pair.body) - velocity(pair.other);
}

PlaneNow plane_now(const ContactPlanes& contacts, std::size_t i, std::span<const Pose> X_WB) {
  const Contact& c = contacts.planes[i];
  const ContactPair pair = contacts.pairs[i];
  const auto body = static_cast<std::size_t>(pair.body);
  PlaneNow plane{transform(X_WB[body], c.p_TC), c.n_W, 0};
  Vec3 p_WS = transform(contacts.X_WB[body], c.p_TC);
  if (pair.other != ContactPair::fixed) {
    const auto other = static_cast<std::size_t>(pair.other);
    const Pose motion = X_WB[other] * inverse(contacts.X_WB[other]);
    p_WS = transform(motion, p_WS);
    plane.n_W = rotate(motion.R, c.n_W);
  }
  const Vec3 moved = plane.p_W - p_WS;
  plane.distance = c.distance + dot(plane.n_W, moved);
  return plane;
}

}  // namespace tactor
