// Rigid tools over deforming surfaces, and the sums that contacts of theirs are judged by.
#pragma once

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "nodes/physics/contact/soft_contacts.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"
#include "tests/support/dice.hpp"

namespace tactor::test {

/// A surface with its nodes, of one deformable body unless faces say another.
struct SoftMesh {
  SoftSurface surface;
  std::vector<Vec3> nodes;  // m, at rest
};

inline SoftMesh soft_mesh(const TriangleMesh& mesh, const Vec3& at = {}) {
  SoftMesh soft;
  for (const Vec3& v : mesh.vertices) soft.nodes.push_back(v + at);
  for (const auto& f : mesh.faces) {
    soft.surface.faces.push_back({f[0], f[1], f[2]});
    soft.surface.body.push_back(0);
    soft.surface.area.push_back(0.5 * norm(doubled_area_normal(mesh, f)));
  }
  return soft;
}

/// An open grid at z = 0 that faces +z: `count` x `count` squares of two triangles over `length` m.
inline TriangleMesh flat_grid(double length, int count) {
  TriangleMesh mesh;
  for (int j = 0; j <= count; ++j) {
    for (int i = 0; i <= count; ++i) {
      mesh.vertices.push_back(
          {length * (static_cast<double>(i) / count - 0.5), length * (static_cast<double>(j) / count - 0.5), 0});
    }
  }
  const auto at = [&](int i, int j) { return j * (count + 1) + i; };
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

inline Material rigid_material() {
  return {.stiffness = 1e6, .damping = 5, .friction = 0.4, .patch_area = 4e-4};
}
inline Material soft_material() {
  return {.stiffness = 1000, .damping = 2, .friction = 0.1, .patch_area = 1e-4};
}
/// N/m of both in series.
inline double both_stiffness() {
  return 1e9 / (1e6 + 1e3);
}

inline Body soft_body(const std::string& name) {
  Body body = shaped(name, BoxShape{{0.1, 0.1, 0.1}}, Motion::deformable);
  body.material = soft_material();
  return body;
}
inline Scene tool_and_soft(const Shape& tool) {
  Scene scene;
  scene.bodies = {soft_body("soft"), shaped("tool", tool, Motion::rigid)};
  scene.bodies[1].material = rigid_material();
  return scene;
}

inline BodyStates tool_at(const Pose& X_WT) {
  BodyStates bodies;
  bodies.count = 1;
  bodies.X_WB[0] = X_WT;
  return bodies;
}

/// A tool over a surface, asked anew.
struct Press {
  Press(const Shape& tool, SoftMesh mesh, const SoftContactOptions& options = {})
      : rest(std::move(mesh)), contacts(tool_and_soft(tool), options, tree_distances()) {
    contacts.set_surface(rest.surface, rest.nodes);
  }
  const std::vector<SoftContact>& at(const Pose& X_WT) { return at(X_WT, rest.nodes); }
  const std::vector<SoftContact>& at(const Pose& X_WT, const std::vector<Vec3>& nodes) {
    contacts.find(nodes, tool_at(X_WT), found);
    return found;
  }
  SoftMesh rest;
  SoftContacts contacts;
  std::vector<SoftContact> found;
};

inline Vec3 spring_force(const Contact& c) {
  return c.distance < 0 ? -c.stiffness * c.weight * c.distance * c.n_W : Vec3{};
}

/// On the rigid body `index`, by springs alone, torque about the world's origin.
inline Wrench spring_wrench(std::span<const SoftContact> found, std::int32_t index = 0) {
  Wrench sum;
  for (const SoftContact& s : found) {
    if (s.body != index) continue;
    const Vec3 force = spring_force(s.contact);
    sum.force += force;
    sum.torque += cross(s.contact.p_WC, force);
  }
  return sum;
}

inline double weight_in_touch(std::span<const SoftContact> found) {
  double sum = 0;
  for (const SoftContact& s : found) sum += s.contact.distance < 0 ? s.contact.weight : 0;
  return sum;
}

/// What holds for every contact: its numbers fit together, and its shares say where on the surface it is.
inline void check_soft(std::span<const SoftContact> found, std::span<const Vec3> nodes, const Pose& X_WT) {
  for (const SoftContact& s : found) {
    const Contact& c = s.contact;
    BOOST_TEST(std::abs(norm(c.n_W) - 1) < 1e-9);
    const Vec3 gap = transform(X_WT, c.p_TC) - c.p_WC;
    BOOST_TEST(std::abs(dot(gap, c.n_W) - c.distance) < 1e-11);
    BOOST_TEST(c.weight > 0);
    BOOST_TEST(std::isfinite(c.weight));
    Vec3 p;
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      BOOST_TEST(s.share[i] > -1e-12);
      sum += s.share[i];
      p += s.share[i] * nodes[static_cast<std::size_t>(s.node[i])];
    }
    BOOST_TEST(std::abs(sum - 1) < 1e-12);
    BOOST_TEST(norm(p - c.p_WC) < 1e-11);
    for (const double h : c.H_W) BOOST_TEST(h == 0.0);
  }
}

}  // namespace tactor::test
