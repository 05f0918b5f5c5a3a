// Contacts of a ball, known in closed form: as a query at any pose gives them, and as the local rollout wants them.
#pragma once

#include <cmath>
#include <vector>

#include "framework/core/messages.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mechanics/contact_correction.hpp"

namespace tactor::test {

/// The distance of a ball from a surface, with its gradient and Hessian, at a place of the ball's centre.
struct SurfaceAt {
  double distance = 0;  // m, of the ball from the surface
  Vec3 n;
  double curvature = 0;  // 1/m: the Hessian is curvature (1 - n n^T)
};

inline SurfaceAt plane_at(const Vec3& x, const Vec3& n, double offset, double radius) {
  return {dot(n, x) - offset - radius, n, 0};
}
/// A ball outside a ball of radius R about c, or inside a hollow one.
inline SurfaceAt ball_at(const Vec3& x, const Vec3& c, double R, double radius, bool hollow) {
  const double far = norm(x - c), side = hollow ? -1 : 1;
  return {side * (far - R) - radius, (side / far) * (x - c), side / far};
}

/// The contact that a query of the ball at X_WT finds.
inline Contact contact_of(const SurfaceAt& s, const Pose& X_WT, double radius, double k = 1000, double b = 2,
                          double mu = 0) {
  Contact c{.n_W = s.n, .distance = s.distance, .weight = 1, .stiffness = k, .damping = b, .friction = mu};
  c.p_TC = rotate(inverse(X_WT.R), -radius * s.n);
  c.p_WC = X_WT.p - (radius + s.distance) * s.n;
  const double h = s.curvature;
  const Vec3& n = s.n;
  c.H_W = {h * (1 - n.x * n.x), -h * n.x * n.y, -h * n.x * n.z,
           h * (1 - n.y * n.y), -h * n.y * n.z, h * (1 - n.z * n.z)};
  return c;
}

/// Local contacts of one contact, looked at at these poses of the bodies by `query(bodies)`.
template <class Query>
LocalContacts around(const std::vector<BodyStates>& anchors, const ContactPair& pair, Query query) {
  LocalContacts local;
  local.anchors = static_cast<std::int32_t>(anchors.size());
  local.bodies = anchors.front().count;
  local.count = 1;
  local.pair[0] = pair;
  for (std::size_t j = 0; j < anchors.size(); ++j) {
    local.X_WB[j] = anchors[j].X_WB;
    local.contact[0][j] = query(anchors[j]);
  }
  return local;
}

/// Writes what a fit has found into the contacts.
inline void correct(const ContactCorrection& correction, LocalContacts& contacts) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    for (Contact& c : contacts.contact[i]) correction.apply(c, contacts.pair[i]);
  }
}

inline BodyStates one_body(const Vec3& p, const Vec3& v = {}) {
  BodyStates bodies;
  bodies.count = 1;
  bodies.X_WB[0].p = p;
  bodies.V_WB[0].v = v;
  return bodies;
}

/// The wall x = 0 met from above by a ball of 1 cm at the anchors, one contact.
inline LocalContacts wall_around(const std::vector<Vec3>& at, double k = 1000, double b = 2, double mu = 0) {
  std::vector<BodyStates> anchors;
  for (const Vec3& p : at) anchors.push_back(one_body(p));
  return around(anchors, {}, [&](const BodyStates& bodies) {
    const Pose& X = bodies.X_WB[0];
    return contact_of(plane_at(X.p, {1, 0, 0}, 0, 0.01), X, 0.01, k, b, mu);
  });
}

}  // namespace tactor::test
