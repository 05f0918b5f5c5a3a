// Rigid bodies that start deep in a deforming body are pushed out on the shortest way, and nothing is judged inside
// beyond the rim of an open surface.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <numbers>

#include "tests/nodes/physics/contact/soft_scenes.hpp"

BOOST_AUTO_TEST_SUITE(soft_deep_test)

using namespace tactor;
using namespace tactor::test;

namespace {

/// A cuboid of 120 x 120 x 60 mm, in faces of some millimetres: its top, at z = 0.03, is near.
SoftMesh slab() {
  TriangleMesh mesh = box({0.12, 0.12, 0.06});
  for (int level = 0; level < 4; ++level) {
    TriangleMesh finer;
    finer.vertices = mesh.vertices;
    std::map<std::pair<int, int>, int> midpoints;
    const auto midpoint = [&](int a, int b) {
      const auto [entry, added] = midpoints.try_emplace(std::minmax(a, b), static_cast<int>(finer.vertices.size()));
      if (added) {
        finer.vertices.push_back(
            0.5 * (mesh.vertices[static_cast<std::size_t>(a)] + mesh.vertices[static_cast<std::size_t>(b)]));
      }
      return entry->second;
    };
    for (const auto& f : mesh.faces) {
      const int a = midpoint(f[0], f[1]), b = midpoint(f[1], f[2]), c = midpoint(f[2], f[0]);
      finer.faces.insert(finer.faces.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    mesh = finer;
  }
  return soft_mesh(mesh);
}

Shape rock(double r) {
  return MeshShape{write_off(icosphere(r, 2), "soft_rock")};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_ball_pressed_deeper_and_deeper_is_never_let_in) {
  for (const double r : {0.004, 0.012}) {
    Press press(SphereShape{r}, slab());
    double most = 0;
    for (double depth = 0.02 * r; depth < 2.4 * r; depth += 0.02 * r) {
      const Pose X{{0.0013, 0.0007, 0.03 + r - depth}, {}};
      check_soft(press.at(X), press.rest.nodes, X);
      const Vec3 force = spring_wrench(press.found).force;
      BOOST_TEST_CONTEXT("radius " << r << ", depth " << depth << ", force " << force.z) {
        BOOST_TEST(force.z > 0.85 * most);
        BOOST_TEST(std::hypot(force.x, force.y) < 0.1 * force.z);
      }
      most = std::max(most, force.z);
    }
  }
}

BOOST_AUTO_TEST_CASE(whatever_starts_deep_is_pushed_out_on_the_shortest_way) {
  const double r = 0.004;
  for (const Shape& tool :
       {Shape(SphereShape{r}), Shape(CapsuleShape{r, 0.02}), Shape(BoxShape{{0.02, 0.01, 0.008}}), rock(0.01)}) {
    Press press(tool, slab());
    for (int i = 0; i < 10; ++i) {
      // All of it is inside, the top is nearest.
      const Pose X{{0.001 * i, -0.002 * i, 0.014 - 0.0005 * i}, from_rotation_vector({0.3 * i, 0.2 * i, 0.1})};
      check_soft(press.at(X), press.rest.nodes, X);
      const Vec3 force = spring_wrench(press.found).force;
      BOOST_TEST(force.z > 0.5);
      BOOST_TEST(std::hypot(force.x, force.y) < 1e-6 * force.z);
    }
    // Near a side it is pushed out there.
    const Pose X{{0.044, 0, 0}, {}};
    press.at(X);
    const Vec3 force = spring_wrench(press.found).force;
    BOOST_TEST(force.x > 0.5);
    BOOST_TEST(std::hypot(force.y, force.z) < 1e-6 * force.x);
  }
}

BOOST_AUTO_TEST_CASE(a_deep_ball_makes_one_contact_of_its_whole_depth) {
  // Larger than the square root of the patch area.
  const double r = 0.015;
  Press press(SphereShape{r}, slab());
  const Pose X{{0, 0, 0.01}, {}};
  BOOST_REQUIRE(press.at(X).size() == 1);
  const Contact& c = press.found[0].contact;
  BOOST_TEST(c.distance == -0.02 - r, boost::test_tools::tolerance(1e-9));
  BOOST_TEST(c.weight == r * r / 1e-4, boost::test_tools::tolerance(1e-9));
  BOOST_TEST(norm(c.n_W - Vec3{0, 0, 1}) < 1e-9);
  BOOST_TEST(norm(c.p_WC - Vec3{0, 0, 0.03}) < 1e-9);
}

BOOST_AUTO_TEST_CASE(a_box_on_a_fine_surface_and_a_fine_box_on_a_coarse_one_feel_the_pressure_of_its_face) {
  // Pressed evenly, 0.3 mm: the face of 24 x 16 mm, and the strip of the sides that the rim stands for.
  const double depth = 0.0003, pressure = both_stiffness() / 1e-4 * depth;
  for (const int count : {2, 8, 60}) {
    Press press(BoxShape{{0.024, 0.016, 0.012}}, soft_mesh(flat_grid(0.06, count)));
    for (int i = 0; i < 10; ++i) {
      const Pose X{{0.0008 * i, -0.0005 * i, 0.006 - depth}, from_rotation_vector({0, 0, 0.1 * i})};
      check_soft(press.at(X), press.rest.nodes, X);
      const Wrench wrench = spring_wrench(press.found);
      BOOST_TEST(wrench.force.z == pressure * 0.024 * 0.016, boost::test_tools::tolerance(0.1));
      BOOST_TEST(std::hypot(wrench.force.x, wrench.force.y) < 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_upright_sides_of_a_box_that_is_pressed_in_do_not_push_it_out) {
  const Vec3 size{0.024, 0.016, 0.012};
  Press press(BoxShape{size}, soft_mesh(flat_grid(0.06, 8)));
  press.at({{0.001, 0.002, size.z / 2 - 0.003}, {}});
  int below = 0;
  for (const SoftContact& s : press.found) {
    if (s.contact.n_W.z < 0.9) continue;
    BOOST_TEST(s.contact.p_TC.z == -size.z / 2, boost::test_tools::tolerance(1e-9));
    ++below;
  }
  BOOST_TEST(below > 10);
}

BOOST_AUTO_TEST_CASE(a_corner_between_the_nodes_of_coarse_faces_is_felt) {
  // A box on its corner, 1 mm deep in faces of 60 mm, and so pushed by its own sample alone or by the surface's.
  const Quat on_corner = from_rotation_vector(Vec3{1, -1, 0} * (std::acos(1 / std::sqrt(3.0)) / std::sqrt(2.0)));
  Press press(BoxShape{{0.02, 0.02, 0.02}}, soft_mesh(flat_grid(0.12, 2)));
  for (int i = 0; i < 20; ++i) {
    const Pose X{{0.011 + 0.0007 * i, -0.02 + 0.0003 * i, 0.01 * std::sqrt(3.0) - 0.001}, on_corner};
    check_soft(press.at(X), press.rest.nodes, X);
    const Vec3 force = spring_wrench(press.found).force;
    BOOST_TEST(force.z > 0);
    double least = 0;
    for (const SoftContact& s : press.found) least = std::min(least, s.contact.distance);
    BOOST_TEST(least == -0.001, boost::test_tools::tolerance(1e-6));
  }
}

BOOST_AUTO_TEST_CASE(beyond_the_rim_of_an_open_surface_nothing_is_inside) {
  const SoftMesh mesh = soft_mesh(flat_grid(0.02, 4));
  const double r = 0.004;
  for (const Shape& tool :
       {Shape(SphereShape{r}), Shape(CapsuleShape{r, 0.004}), Shape(BoxShape{{0.005, 0.004, 0.003}})}) {
    Press press(tool, mesh);
    // Below the surface and beside it.
    for (const Vec3& p : {Vec3{0.0155, 0, -0.002}, Vec3{0.016, 0.016, -0.005}, Vec3{-0.03, 0, -0.01}}) {
      BOOST_TEST(press.at({p, {}}).empty());
    }
    // Below it, and deep.
    press.at({{0.001, 0.001, -0.006}, {}});
    BOOST_TEST(spring_wrench(press.found).force.z > 0.1);
    // So deep that it is another side of whatever the surface is of.
    BOOST_TEST(press.at({{0.001, 0.001, -0.04}, {}}).empty());
  }
}

BOOST_AUTO_TEST_SUITE_END()
