// Bodies of every shape for scenes of contact, and what holds for every contact of a set.
#pragma once

#include <string>

#include <boost/test/unit_test.hpp>

#include "framework/core/messages.hpp"
#include "tests/support/nodes.hpp"
#include "tests/support/shapes.hpp"

namespace tactor::test {

inline Body shaped(const std::string& name, const Shape& shape, Motion motion = Motion::fixed) {
  Body body;
  body.name = name;
  body.shape = shape;
  body.motion = motion;
  return body;
}
inline Body mesh_body(const std::string& name, const TriangleMesh& mesh, Motion motion = Motion::fixed) {
  return shaped(name, MeshShape{write_off(mesh, "collision_" + name)}, motion);
}
inline Body ball(const std::string& name, double radius, Motion motion = Motion::fixed) {
  return shaped(name, SphereShape{radius}, motion);
}

inline std::span<const Contact> contacts_of(const ContactSet& set) {
  return {set.contact.data(), static_cast<std::size_t>(set.count)};
}

/// Each contact's distance is that between its two points along its unit normal, from the other body to the moving one,
/// and its Hessian is symmetric and turns the normal alone, not the distance along it.
inline void check_geometry(const ContactSet& set) {
  int penetrating = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const Contact& c = set.contact[i];
    const ContactPair pair = set.pair[i];
    BOOST_TEST(pair.body >= 0);
    BOOST_TEST(pair.body < set.bodies.count);
    BOOST_TEST((pair.other == ContactPair::fixed || (pair.other > pair.body && pair.other < set.bodies.count)));
    BOOST_TEST(std::abs(norm(c.n_W) - 1) < 1e-12);
    const Vec3 gap = transform(set.bodies.X_WB[static_cast<std::size_t>(pair.body)], c.p_TC) - c.p_WC;
    BOOST_TEST(norm(gap - c.distance * c.n_W) < 1e-11);
    BOOST_TEST(c.weight > 0);
    const Vec3 n = c.n_W;
    const std::array<double, 6>& H = c.H_W;
    const Vec3 along{H[0] * n.x + H[1] * n.y + H[2] * n.z, H[1] * n.x + H[3] * n.y + H[4] * n.z,
                     H[2] * n.x + H[4] * n.y + H[5] * n.z};
    BOOST_TEST(norm(along) <= 1e-9 * (1 + std::abs(H[0]) + std::abs(H[3]) + std::abs(H[5])));
    penetrating += c.distance < 0 ? 1 : 0;
  }
  BOOST_TEST(set.penetrating == penetrating);
}

/// Force and torque about the world's origin on the body `index` of Scene::moving(), by springs alone.
inline Wrench spring_wrench(const ContactSet& set, std::int32_t index = 0) {
  Wrench sum;
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const Contact& c = set.contact[i];
    if (c.distance >= 0) continue;
    const double side = set.pair[i].body == index ? 1 : set.pair[i].other == index ? -1 : 0;
    const Vec3 force = -side * c.stiffness * c.weight * c.distance * c.n_W;
    sum.force += force;
    sum.torque += cross(c.p_WC, force);
  }
  return sum;
}

/// The deepest contact's distance in m, or the margin where there is none.
inline double deepest(const ContactSet& set, double margin) {
  double least = margin;
  for (const Contact& c : contacts_of(set)) least = std::min(least, c.distance);
  return least;
}

}  // namespace tactor::test
