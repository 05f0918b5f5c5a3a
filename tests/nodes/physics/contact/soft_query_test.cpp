// Queries of deforming surfaces: bounded work, no calls of the heap, the same bytes again, forces that a choice of
// contacts keeps and that do not jump, and input that is no geometry.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>

#include "framework/core/value_error.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "tests/nodes/physics/contact/soft_scenes.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(soft_query_test)

using namespace tactor;
using namespace tactor::test;

namespace {

struct Tool {
  const char* name;
  Shape shape;
  double lift;  // m, of its origin where it touches a plane z = 0
  Quat turn{};
};

std::vector<Tool> tools() {
  const Quat lying = from_rotation_vector({0.5 * std::numbers::pi, 0, 0});
  return {{"ball", SphereShape{0.006}, 0.006},
          {"rod", CapsuleShape{0.003, 0.02}, 0.003, lying},
          {"needle", CapsuleShape{0.001, 0.04}, 0.021},
          {"box", BoxShape{{0.02, 0.014, 0.01}}, 0.005},
          {"rock", MeshShape{write_off(icosphere(0.008, 3), "soft_query_rock")}, 0.008}};
}

double bump(double x, double y) {
  return 0.0015 * std::sin(300 * x) * std::cos(250 * y + 0.3);
}

/// Bumps of 1.5 mm in squares of 6 mm.
SoftMesh bumpy() {
  TriangleMesh mesh = flat_grid(0.12, 20);
  for (Vec3& p : mesh.vertices) p.z = bump(p.x, p.y);
  return soft_mesh(mesh);
}

/// 60 faces over 42 nodes.
SoftMesh patch_of(double length) {
  SoftMesh mesh = soft_mesh(flat_grid(length, 6));
  mesh.surface.faces.resize(60);
  mesh.surface.body.resize(60);
  mesh.surface.area.resize(60);
  mesh.nodes.resize(42);
  return mesh;
}

bool find_on(SoftContacts& contacts, const SoftMesh& mesh, const std::vector<Vec3>& nodes, const Pose& X_WT,
             std::vector<SoftContact>& found) {
  const SoftSurface& s = mesh.surface;
  return contacts.find_on(s.faces, s.body, s.area, nodes, X_WT, found);
}

void waved(const std::vector<Vec3>& rest, int k, std::vector<Vec3>& nodes) {
  for (std::size_t i = 0; i < rest.size(); ++i) {
    nodes[i] = rest[i] + Vec3{0, 0, 0.0005 * std::sin(90 * rest[i].x + 0.3 * k) * std::cos(70 * rest[i].y)};
  }
}

bool same(const std::vector<SoftContact>& a, const std::vector<SoftContact>& b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](const SoftContact& s, const SoftContact& t) {
           const Contact &c = s.contact, &d = t.contact;
           return c.p_TC == d.p_TC && c.p_WC == d.p_WC && c.n_W == d.n_W && c.distance == d.distance &&
                  c.weight == d.weight && s.body == t.body && s.node == t.node && s.share == t.share;
         });
}

bool is_finite(const SoftContact& s) {
  const Contact& c = s.contact;
  double sum = c.distance + c.weight + c.stiffness + c.damping + c.friction + s.share[0] + s.share[1] + s.share[2];
  for (const Vec3& v : {c.p_TC, c.p_WC, c.n_W}) sum += v.x + v.y + v.z;
  return std::isfinite(sum);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_query_of_a_patch_allocates_nothing_from_the_first_one_on,
                     *boost::unit_test::precondition(heap_is_counted)) {
  for (const Tool& tool : tools()) {
    BOOST_TEST_CONTEXT(tool.name) {
      Scene scene = tool_and_soft(tool.shape);
      scene.bodies.push_back(soft_body("other"));
      SoftContacts contacts(scene, {}, tree_distances());
      std::vector<SoftContact> found;
      found.reserve(ContactSet::capacity);
      SoftMesh mesh = patch_of(0.02);
      for (std::size_t k = 0; k < 60; k += 3) mesh.surface.body[k] = 1;
      std::vector<Vec3> nodes = mesh.nodes;
      std::size_t most = 0;
      for (int k = 0; k < 60; ++k) {
        waved(mesh.nodes, k, nodes);
        const Pose X{{0.0002 * k - 0.005, -0.002, tool.lift - 0.0002 * k}, tool.turn};
        // Other faces now and then.
        if (k % 7 == 0) std::swap(mesh.surface.faces[0], mesh.surface.faces[static_cast<std::size_t>(k)]);
        const std::int64_t before = thread_heap_calls();
        BOOST_TEST(find_on(contacts, mesh, nodes, X, found));
        const std::int64_t calls = thread_heap_calls() - before;
        BOOST_TEST(calls == 0);
        most = std::max(most, found.size());
      }
      BOOST_TEST(most > 10);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_query_of_the_whole_surface_allocates_nothing_once_it_has_met_the_most_contacts,
                     *boost::unit_test::precondition(heap_is_counted)) {
  for (const Tool& tool : tools()) {
    BOOST_TEST_CONTEXT(tool.name) {
      Press press(tool.shape, bumpy());
      std::vector<Vec3> nodes = press.rest.nodes;
      std::int64_t before = 0;
      for (int k = 0; k < 80; ++k) {
        if (k == 40) before = thread_heap_calls();
        waved(press.rest.nodes, k % 40, nodes);
        press.at({{0.0002 * (k % 40), 0, tool.lift - 0.0001 * (k % 40)}, tool.turn}, nodes);
      }
      BOOST_TEST(!press.found.empty());
      BOOST_TEST(thread_heap_calls() == before);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_query_of_a_patch_ends_where_its_work_does) {
  for (const Tool& tool : tools()) {
    BOOST_TEST_CONTEXT(tool.name) {
      const SoftMesh mesh = patch_of(0.02);
      const Pose X{{0.001, 0.002, tool.lift - 0.001}, tool.turn};
      std::vector<SoftContact> found, all;
      SoftContacts ample(tool_and_soft(tool.shape), {}, tree_distances());
      BOOST_REQUIRE(find_on(ample, mesh, mesh.nodes, X, all));
      const int needed = ample.work();
      BOOST_TEST(needed > 60);
      for (const int most : {0, 1, needed / 2, needed - 1, needed, needed + 1}) {
        SoftContactOptions options;
        options.soft_work = most;
        SoftContacts bounded(tool_and_soft(tool.shape), options, tree_distances());
        const bool enough = find_on(bounded, mesh, mesh.nodes, X, found);
        BOOST_TEST(enough == (most >= needed));
        BOOST_TEST(found.empty() == !enough);
        if (enough) BOOST_TEST(same(found, all));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_same_queries_find_the_same_bytes) {
  for (const Tool& tool : tools()) {
    SoftContactOptions options;
    options.soft_contacts = 24;
    Press a(tool.shape, bumpy(), options), b(tool.shape, bumpy(), options);
    std::vector<Vec3> nodes = a.rest.nodes;
    for (int k = 0; k < 20; ++k) {
      waved(a.rest.nodes, k, nodes);
      const Pose X{{0.0005 * k, 0, tool.lift - 0.0015}, tool.turn};
      BOOST_TEST(same(a.at(X, nodes), b.at(X, nodes)));
    }
  }
}

BOOST_AUTO_TEST_CASE(of_many_contacts_those_kept_have_the_force_and_the_torque_of_all) {
  // So coarse that all are no more than a set holds.
  const std::map<std::string, double> spacings{{"ball", 0.0012}, {"rod", 0.002}, {"box", 0.004}, {"rock", 0.0015}};
  for (const Tool& tool : tools()) {
    if (!spacings.contains(tool.name)) continue;
    BOOST_TEST_CONTEXT(tool.name) {
      SoftContactOptions more, few;
      more.soft_margin = few.soft_margin = 0.0001;
      more.soft_spacing = few.soft_spacing = spacings.at(tool.name);
      few.soft_contacts = 32;
      Press all(tool.shape, bumpy(), more), some(tool.shape, bumpy(), few);
      int compared = 0, exact = 0;
      for (int k = 0; k < 40; ++k) {
        const double x = 0.0007 * k - 0.014;
        const Pose X{{x, 0.3 * x, tool.lift + bump(x, 0.3 * x) - 0.0006}, tool.turn};
        all.at(X);
        some.at(X);
        BOOST_TEST(some.found.size() <= 32U);
        if (all.found.size() == ContactSet::capacity || all.found.size() <= 32) continue;
        const Wrench whole = spring_wrench(all.found), part = spring_wrench(some.found);
        // The weights change by a half at most in each of a few steps, which now and then is not enough.
        const double off = norm(whole.force - part.force) / norm(whole.force),
                     turned_off = norm(whole.torque - part.torque) / (tool.lift * norm(whole.force));
        BOOST_TEST(off < 0.02);
        BOOST_TEST(turned_off < 0.2);
        exact += off < 1e-6 && turned_off < 1e-6 ? 1 : 0;
        ++compared;
      }
      BOOST_TEST(compared > 5);
      BOOST_TEST(exact >= 0.8 * compared);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_force_does_not_jump_as_a_tool_is_led_over_bumps) {
  // Steps of 10 um. Where a force grows by the stiffness of the deepest contacts in such a step, it changes by a few
  // mN; where a contact came or went, or turned, at once, by its whole force.
  for (const Tool& tool : tools()) {
    for (const int most : {ContactSet::capacity, 32}) {
      SoftContactOptions options;
      options.soft_contacts = most;
      Press press(tool.shape, bumpy(), options);
      Vec3 last;
      double worst = 0, largest = 0;
      int steps = 0;
      for (double x = -0.015; x < 0.015; x += 1e-5) {
        const Pose X{{x, 0.37 * x, tool.lift + bump(x, 0.37 * x) - 0.0006}, tool.turn};
        const Vec3 force = spring_wrench(press.at(X)).force;
        if (steps++ > 0) worst = std::max(worst, norm(force - last));
        largest = std::max(largest, norm(force));
        last = force;
      }
      BOOST_TEST_MESSAGE(tool.name << ", at most " << most << " contacts: largest force " << largest
                                   << " N, largest change in 10 um " << worst << " N");
      BOOST_TEST_CONTEXT(tool.name << ", most " << most) {
        BOOST_TEST(largest > 0.003);
        BOOST_TEST(worst < 0.06 * largest);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(input_that_is_no_geometry_makes_no_contact_that_is_not_finite) {
  const double none = std::numeric_limits<double>::quiet_NaN(), endless = std::numeric_limits<double>::infinity();
  const std::array<double, 8> odd{none, endless, -endless, 0.0, 1e300, -1e160, 1e-300, 1e9};
  Dice dice(21);
  const auto any = [&] { return odd[static_cast<std::size_t>(dice(0, 8))]; };
  for (const Tool& tool : tools()) {
    BOOST_TEST_CONTEXT(tool.name) {
      int some = 0;
      for (int round = 0; round < 150; ++round) {
        SoftMesh mesh = patch_of(0.02);
        for (int i = round % 5; i-- > 0;) mesh.surface.area[static_cast<std::size_t>(dice(0, 60))] = any();
        // Faces that are flat to an edge or a point, turned, doubled, or one of a node twice.
        for (int i = round % 7; i-- > 0;) {
          auto& face = mesh.surface.faces[static_cast<std::size_t>(dice(0, 60))];
          face[static_cast<std::size_t>(dice(0, 3))] = static_cast<std::int32_t>(dice(0, 42));
        }
        std::vector<Vec3> nodes = mesh.nodes;
        for (int i = round % 11; i-- > 0;) {
          nodes[static_cast<std::size_t>(dice(0, 42))] = nodes[static_cast<std::size_t>(dice(0, 42))];
        }
        for (int i = round % 3; i-- > 0;) nodes[static_cast<std::size_t>(dice(0, 42))][i] = any();
        Press press(tool.shape, mesh);
        std::vector<SoftContact> found;
        for (int i = 0; i < 6; ++i) {
          Pose X{{dice(-0.005, 0.005), dice(-0.005, 0.005), tool.lift - dice(0, 0.004)}, tool.turn};
          if (i == 4) X.p[round % 3] = any();
          if (i == 5) X.R.w = any();
          press.at(X, nodes);
          find_on(press.contacts, mesh, nodes, X, found);
          for (const auto* contacts : {&press.found, &found}) {
            for (const SoftContact& s : *contacts) {
              BOOST_TEST(is_finite(s));
              if (i < 4) BOOST_TEST(std::abs(norm(s.contact.n_W) - 1) < 1e-9);
              ++some;
            }
          }
        }
      }
      BOOST_TEST(some > 1000);
    }
  }
}

BOOST_AUTO_TEST_CASE(two_deformable_bodies_and_several_rigid_ones_are_told_apart) {
  Scene scene;
  scene.bodies = {soft_body("left"), shaped("floor", PlaneShape{}), soft_body("right"),
                  ball("other", 0.01, Motion::rigid), ball("tool", 0.006, Motion::translation)};
  scene.tool_name = "tool";
  scene.bodies[2].material.friction = 0.9;
  for (const std::size_t i : {1U, 3U, 4U}) scene.bodies[i].material = rigid_material();
  // Grids side by side, whose faces take turns.
  const TriangleMesh grid = flat_grid(0.05, 5);
  SoftMesh both;
  for (std::size_t k = 0; k < grid.faces.size(); ++k) {
    for (const int side : {0, 1}) {
      const int first = side * static_cast<int>(grid.vertices.size());
      const auto& f = grid.faces[k];
      both.surface.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
      both.surface.body.push_back(side);
      both.surface.area.push_back(0.5 * 0.01 * 0.01);
    }
  }
  for (const double x : {-0.025, 0.025}) {
    for (const Vec3& p : grid.vertices) both.nodes.push_back(p + Vec3{x, 0, 0.001});
  }
  SoftContactOptions options;
  options.soft_contacts = 24;
  SoftContacts contacts(scene, options, tree_distances());
  contacts.set_surface(both.surface, both.nodes);
  BodyStates bodies;
  bodies.count = 2;
  bodies.X_WB[0].p = {0, 0, 0.0055};
  bodies.X_WB[1].p = {0.02, 0, 0.0105};
  std::vector<SoftContact> found;
  contacts.find(both.nodes, bodies, found);
  BOOST_TEST(found.size() == 24U);
  std::array<int, 2> of_body{};
  std::array<int, 2> of_side{};
  for (const SoftContact& s : found) {
    BOOST_REQUIRE((s.body == 0 || s.body == 1));  // the surface faces away from the floor
    const bool right = s.node[0] >= static_cast<int>(grid.vertices.size());
    BOOST_TEST(s.contact.friction == std::sqrt(0.4 * (right ? 0.9 : 0.1)), boost::test_tools::tolerance(1e-12));
    ++of_body[static_cast<std::size_t>(s.body)];
    if (s.body == 0) ++of_side[right ? 1 : 0];
  }
  BOOST_TEST(of_body[0] > 3);
  BOOST_TEST(of_body[1] > 3);
  BOOST_TEST(of_side[0] > 0);
  BOOST_TEST(of_side[1] > 0);
  // The tool lies on the seam, the same on both sides.
  const Wrench wrench = spring_wrench(found, 0);
  BOOST_TEST(wrench.force.z > 0);
}

BOOST_AUTO_TEST_CASE(options_out_of_bounds_are_refused_by_name) {
  const auto refused = [](SoftContactOptions options) {
    try {
      SoftContacts contacts(tool_and_soft(SphereShape{0.01}), options, tree_distances());
    } catch (const ValueError& error) {
      return error.path();
    }
    return std::string();
  };
  BOOST_TEST(refused({}) == "");
  BOOST_TEST(refused({.soft_margin = -1e-3}) == "margin");
  BOOST_TEST(refused({.soft_margin = std::numeric_limits<double>::quiet_NaN()}) == "margin");
  BOOST_TEST(refused({.soft_spacing = -1}) == "spacing");
  BOOST_TEST(refused({.soft_contacts = 3}) == "max_contacts");
  BOOST_TEST(refused({.soft_contacts = 129}) == "max_contacts");
  BOOST_TEST(refused({.soft_work = -1}) == "most_work");
}

BOOST_AUTO_TEST_CASE(without_a_tool_or_faces_nothing_is_found) {
  Scene scene;
  scene.bodies = {soft_body("soft"), shaped("floor", PlaneShape{})};
  SoftContacts contacts(scene, {}, tree_distances());
  std::vector<SoftContact> found(3);
  const SoftMesh mesh = patch_of(0.02);
  BOOST_TEST(find_on(contacts, mesh, mesh.nodes, {}, found));
  BOOST_TEST(found.empty());
  Press press(SphereShape{0.01}, {});
  BOOST_TEST(press.at({}).empty());
}

BOOST_AUTO_TEST_SUITE_END()
