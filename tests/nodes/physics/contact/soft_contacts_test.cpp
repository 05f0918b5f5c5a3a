// Rigid bodies on deforming surfaces: pressure, signs, and what must not depend on where or how the surface is.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/nodes/physics/contact/soft_scenes.hpp"

BOOST_AUTO_TEST_SUITE(soft_contacts_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double patch_area = 1e-4;  // of the softer material

/// N, of a ball pressed by d into a flat surface that stays flat: the pressure K (r - s) along the normal at distance s
/// from the centre, summed over the circle where s < r: pi K (r - d) d^2.
double ball_force(double r, double d) {
  return std::numbers::pi * both_stiffness() / patch_area * (r - d) * d * d;
}

double relative(double a, double b) {
  return std::abs(a - b) / std::abs(b);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_materials_of_both_bodies_make_the_contact) {
  Press press(SphereShape{0.01}, soft_mesh(flat_grid(0.06, 12)));
  BOOST_REQUIRE(!press.at({{0, 0, 0.009}, {}}).empty());
  for (const SoftContact& s : press.found) {
    BOOST_TEST(s.contact.stiffness == both_stiffness(), boost::test_tools::tolerance(1e-12));
    BOOST_TEST(s.contact.damping == 2.0);
    BOOST_TEST(s.contact.friction == 0.2, boost::test_tools::tolerance(1e-12));
    BOOST_TEST(s.body == 0);
  }
}

BOOST_AUTO_TEST_CASE(a_flat_tool_pressed_evenly_weighs_as_many_patches_as_it_covers) {
  // The surface of 40 mm lies below the tool of 60 mm, whose own samples, 7.5 mm apart, count for nothing beyond it.
  for (const int count : {1, 7, 20}) {
    for (const double depth : {0.0002, 0.001}) {
      Press press(BoxShape{{0.06, 0.06, 0.02}}, soft_mesh(flat_grid(0.04, count)));
      press.at({{0.002, -0.003, 0.01 - depth}, {}});
      check_soft(press.found, press.rest.nodes, {{0.002, -0.003, 0.01 - depth}, {}});
      const Wrench wrench = spring_wrench(press.found);
      BOOST_TEST(weight_in_touch(press.found) == 0.04 * 0.04 / patch_area, boost::test_tools::tolerance(0.05));
      BOOST_TEST(wrench.force.z == both_stiffness() * 16 * depth, boost::test_tools::tolerance(0.05));
      BOOST_TEST(std::abs(wrench.force.x) + std::abs(wrench.force.y) < 1e-9);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_plane_on_a_surface_weighs_its_area_whatever_the_faces) {
  for (const int count : {1, 3, 9}) {
    Scene scene;
    scene.bodies = {soft_body("soft"), shaped("table", PlaneShape{})};
    scene.bodies[1].material = rigid_material();
    // The surface faces down, 0.3 mm in the table.
    TriangleMesh grid = flat_grid(0.04, count);
    for (auto& f : grid.faces) std::swap(f[0], f[1]);
    SoftMesh mesh = soft_mesh(grid, {0, 0, -0.0003});
    SoftContacts contacts(scene, {}, tree_distances());
    contacts.set_surface(mesh.surface, mesh.nodes);
    std::vector<SoftContact> found;
    contacts.find(mesh.nodes, {}, found);
    BOOST_TEST(weight_in_touch(found) == 0.04 * 0.04 / patch_area, boost::test_tools::tolerance(1e-9));
    for (const SoftContact& s : found) {
      BOOST_TEST(s.body == ContactPair::fixed);
      BOOST_TEST(norm(s.contact.n_W - Vec3{0, 0, -1}) < 1e-12);  // the table is below
    }
    const Wrench wrench = spring_wrench(found, ContactPair::fixed);
    BOOST_TEST(wrench.force.z == -both_stiffness() * 16 * 0.0003, boost::test_tools::tolerance(1e-9));
    BOOST_TEST(norm(wrench.torque) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(a_ball_pressed_into_a_flat_surface_feels_the_pressure_of_its_cap) {
  const double r = 0.01;
  // The error of a sum over a lattice falls at least with its spacing.
  for (const double d : {0.0008, 0.002, 0.004}) {
    for (const int count : {4, 11, 40}) {
      for (const auto& [spacing, most] : {std::pair{0.0, 0.12}, {0.001, 0.03}, {0.0005, 0.01}}) {
        SoftContactOptions options;
        options.soft_spacing = spacing;
        Press press(SphereShape{r}, soft_mesh(flat_grid(0.06, count)), options);
        double worst = 0;
        for (int i = 0; i < 5; ++i) {
          const Pose X{{0.0007 * i, 0.0011 * i, r - d}, from_rotation_vector({0.1 * i, 0.2, 0})};
          check_soft(press.at(X), press.rest.nodes, X);
          const Vec3 force = spring_wrench(press.found).force;
          worst = std::max(worst, relative(force.z, ball_force(r, d)));
          BOOST_TEST(std::hypot(force.x, force.y) < most * force.z);
        }
        BOOST_TEST_CONTEXT("depth " << d << ", squares " << count << ", spacing " << spacing) {
          BOOST_TEST(worst < most);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_normal_leads_from_the_surface_to_the_tool_and_the_nodes_feel_the_reverse) {
  Press press(SphereShape{0.01}, soft_mesh(flat_grid(0.06, 12)));
  const Pose X{{0, 0, 0.008}, {}};
  int inside = 0, near = 0;
  for (const SoftContact& s : press.at(X)) {
    const Vec3 to_centre = X.p - s.contact.p_WC;
    BOOST_TEST(norm(s.contact.n_W - to_centre / norm(to_centre)) < 1e-12);
    BOOST_TEST(std::abs(s.contact.distance - (norm(to_centre) - 0.01)) < 1e-12);
    BOOST_TEST(s.contact.distance < 0.002);
    (s.contact.distance < 0 ? inside : near) += 1;
  }
  BOOST_TEST(inside > 5);
  BOOST_TEST(near > 5);
}

BOOST_AUTO_TEST_CASE(moving_the_nodes_is_moving_the_tool_the_other_way) {
  const TriangleMesh mesh = icosphere(0.03, 2);
  Dice dice(3);
  for (const Shape& tool :
       {Shape(SphereShape{0.01}), Shape(CapsuleShape{0.004, 0.03}), Shape(BoxShape{{0.02, 0.014, 0.01}})}) {
    Press a(tool, soft_mesh(mesh)), b(tool, soft_mesh(mesh));
    for (int i = 0; i < 20; ++i) {
      const Vec3 way = dice.in_cube(0.05);
      const Pose X{dice.in_cube(1), from_rotation_vector(dice.in_cube(2))};
      Pose near = X;
      near.p = X.p / norm(X.p) * 0.034;
      std::vector<Vec3> moved = a.rest.nodes;
      for (Vec3& p : moved) p += way;
      const Wrench one = spring_wrench(a.at({near.p + way, near.R}, moved)), other = spring_wrench(b.at(near));
      BOOST_TEST(a.found.size() == b.found.size());
      BOOST_TEST(norm(one.force - other.force) < 1e-6 * (1 + norm(other.force)));
    }
  }
}

BOOST_AUTO_TEST_CASE(turned_and_shifted_together_a_tool_and_a_surface_have_the_same_contacts) {
  const TriangleMesh mesh = icosphere(0.03, 2);
  Dice dice(4);
  int some = 0;
  for (const Shape& tool :
       {Shape(SphereShape{0.01}), Shape(CapsuleShape{0.004, 0.03}), Shape(BoxShape{{0.02, 0.014, 0.01}})}) {
    Press a(tool, soft_mesh(mesh)), b(tool, soft_mesh(mesh));
    for (int i = 0; i < 20; ++i) {
      const Pose to = dice.pose(0.1, 2);
      Pose X{dice.in_cube(1), from_rotation_vector(dice.in_cube(2))};
      X.p = X.p / norm(X.p) * 0.036;
      std::vector<Vec3> moved = a.rest.nodes;
      for (Vec3& p : moved) p = transform(to, p);
      a.at(X);
      b.at(to * X, moved);
      check_soft(b.found, moved, to * X);
      if (a.found.size() == ContactSet::capacity) continue;  // chosen, with what was kept last time
      BOOST_REQUIRE(a.found.size() == b.found.size());
      for (std::size_t k = 0; k < a.found.size(); ++k) {
        const SoftContact &s = a.found[k], &t = b.found[k];
        BOOST_TEST((s.node == t.node));
        BOOST_TEST(norm(s.contact.p_TC - t.contact.p_TC) < 1e-10);
        BOOST_TEST(norm(transform(to, s.contact.p_WC) - t.contact.p_WC) < 1e-10);
        BOOST_TEST(norm(rotate(to.R, s.contact.n_W) - t.contact.n_W) < 1e-7);
        BOOST_TEST(std::abs(s.contact.weight - t.contact.weight) < 1e-7);
        ++some;
      }
    }
  }
  BOOST_TEST(some > 500);
}

BOOST_AUTO_TEST_CASE(samples_go_by_the_area_at_rest) {
  // Stretched to twice its length the surface has the same samples, each of the same weight.
  SoftContactOptions options;
  options.soft_margin = 0.1;
  options.soft_spacing = 0.005;
  Press all(SphereShape{0.01}, soft_mesh(flat_grid(0.02, 4)), options);
  std::vector<Vec3> wide = all.rest.nodes;
  for (Vec3& p : wide) p.x *= 2;
  double sums[2];
  for (const int i : {0, 1}) {
    sums[i] = 0;
    // So high that all face the ball.
    all.at({{0, 0, 0.05}, {}}, i == 0 ? all.rest.nodes : wide);
    for (const SoftContact& s : all.found) sums[i] += s.contact.weight;
  }
  BOOST_TEST(sums[0] == 0.02 * 0.02 / patch_area, boost::test_tools::tolerance(1e-9));
  BOOST_TEST(sums[1] == sums[0], boost::test_tools::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(a_needle_on_coarse_faces_is_seen_and_pushed_by_its_tip) {
  // 1 mm on faces of 10 mm: the samples go by the needle.
  const double r = 0.001, d = 0.0004;
  Press press(CapsuleShape{r, 0.04}, soft_mesh(flat_grid(0.1, 10)));
  Dice dice(8);
  for (int i = 0; i < 200; ++i) {
    const Pose X{{dice(-0.03, 0.03), dice(-0.03, 0.03), 0.02 + r - d}, {}};
    press.at(X);
    BOOST_REQUIRE(!press.found.empty());
    BOOST_TEST(relative(spring_wrench(press.found).force.z, ball_force(r, d)) < 0.45);
  }
}

BOOST_AUTO_TEST_CASE(a_patch_of_faces_has_the_contacts_that_the_whole_has_there) {
  // The tool touches the first 60 faces of 72 alone.
  const SoftMesh mesh = soft_mesh(flat_grid(0.024, 6));
  for (const Shape& tool : {Shape(SphereShape{0.005}), Shape(CapsuleShape{0.003, 0.008})}) {
    Press press(tool, mesh);
    std::vector<Vec3> nodes = mesh.nodes;
    std::vector<SoftContact> found;
    for (int i = 0; i < 30; ++i) {
      const Pose X{{0.0002 * i, -0.0001 * i - 0.002, 0.0045}, from_rotation_vector({1.5, 0.1 * i, 0})};
      for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k].z = 1e-4 * std::sin(0.3 * static_cast<double>(k) + i);
      press.at(X, nodes);
      const SoftSurface& s = mesh.surface;
      BOOST_REQUIRE(press.contacts.find_on(std::span(s.faces).first(60), std::span(s.body).first(60),
                                           std::span(s.area).first(60), std::span(nodes).first(42), X, found));
      BOOST_REQUIRE(found.size() == press.found.size());
      BOOST_TEST(found.size() > 10);
      for (std::size_t k = 0; k < found.size(); ++k) {
        BOOST_TEST((found[k].node == press.found[k].node));
        BOOST_TEST((found[k].contact.p_WC == press.found[k].contact.p_WC));
        BOOST_TEST((found[k].contact.n_W == press.found[k].contact.n_W));
        BOOST_TEST(found[k].contact.weight == press.found[k].contact.weight);
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
