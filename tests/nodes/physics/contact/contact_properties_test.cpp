// What holds for the contacts of every kind of collision and every shape: no frame, order or history matters.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <set>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/collision/exact.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/collision/sdf.hpp"
#include "nodes/physics/contact/scene_contacts.hpp"
#include "nodes/physics/contact/surface_contacts.hpp"
#include "nodes/physics/geometry/mesh_distance.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(contact_properties_test)

using namespace tactor;

namespace {

TriangleMesh rock(double radius) {
  TriangleMesh mesh = test::icosphere(radius, 2);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.vertices[i] *= i % 3 == 0 ? 1.06 : i % 3 == 1 ? 0.97 : 1.0;
  return mesh;
}

/// About 0.02 m in every direction.
Shape tool_shape(const std::string& name) {
  if (name == "sphere") return SphereShape{0.02};
  if (name == "capsule") return CapsuleShape{.radius = 0.0175, .length = 0.009};
  if (name == "box") return BoxShape{{0.034, 0.03, 0.036}};
  return MeshShape{test::write_off(rock(0.02), "properties_tool")};
}

/// Bodies of every shape on all sides of a tool at the origin.
Scene scene_about(const Shape& tool, Motion motion = Motion::rigid) {
  Scene scene;
  scene.bodies = {test::shaped("tool", tool, motion),
                  test::mesh_body("rock", rock(0.03)),
                  test::ball("ball", 0.03),
                  test::shaped("rod", CapsuleShape{.radius = 0.01, .length = 0.05}),
                  test::shaped("block", BoxShape{{0.04, 0.02, 0.03}}),
                  test::shaped("floor", PlaneShape{})};
  scene.bodies[1].X_WB = {{0.048, 0.003, 0.002}, from_rotation_vector({0.3, 0.2, 0.1})};
  scene.bodies[2].X_WB = {{-0.0485, 0.001, 0}, {}};
  scene.bodies[3].X_WB = {{0.002, 0.029, 0.003}, from_rotation_vector({0.2, 1.3, 0.4})};
  scene.bodies[4].X_WB = {{-0.001, -0.027, 0.004}, from_rotation_vector({0.1, -0.2, 0.35})};
  scene.bodies[5].X_WB = {{0, 0, -0.017}, from_rotation_vector({0.05, 0.02, 0})};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    scene.bodies[i].material.stiffness = 1000.0 * static_cast<double>(i + 1);
  }
  return scene;
}

struct Case {
  std::string kind, tool;
};
std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << "collision." << c.kind << " of a " << c.tool;
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all{{"exact", "mesh"},    {"exact", "sphere"},     {"exact", "box"},
                                     {"sdf", "mesh"},      {"sdf", "capsule"},      {"primitive", "sphere"},
                                     {"primitive", "box"}, {"primitive", "capsule"}};
  return all;
}

constexpr double margin = 0.001;

template <class N>
std::unique_ptr<PairCollision> made(const Scene& scene, double spacing = 0) {
  auto params = test::default_params<N>();
  params.margin = margin;
  params.spacing = spacing;
  // Coarse cells are soon made.
  if constexpr (requires { params.resolution; }) params.resolution = 24;
  return std::make_unique<N>(params, test::context_for(scene));
}

std::unique_ptr<PairCollision> node_of(const Case& c, const Scene& scene) {
  // A box and a mesh of large triangles touch at so many samples that the set would be full.
  const double spacing = c.tool == "box" || c.tool == "mesh" ? 0.012 : 0;
  if (c.kind == "exact") return made<ExactCollision>(scene, spacing);
  if (c.kind == "sdf") return made<SdfCollision>(scene, spacing);
  return made<PrimitiveCollision>(scene, spacing);
}

Vec3 times(const std::array<double, 6>& H, const Vec3& v) {
  return {H[0] * v.x + H[1] * v.y + H[2] * v.z, H[1] * v.x + H[3] * v.y + H[4] * v.z,
          H[2] * v.x + H[4] * v.y + H[5] * v.z};
}

/// How far the contacts of `b` are from those of `a`, each seen from outside: points and normals in the world.
struct Seen {
  Vec3 on_body, on_other, n_W, turned;
  double distance, weight, stiffness;
};
std::vector<Seen> seen(const ContactSet& set, bool exchanged) {
  std::vector<Seen> all;
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const Contact& c = set.contact[i];
    const Vec3 p = transform(set.bodies.X_WB[static_cast<std::size_t>(set.pair[i].body)], c.p_TC);
    const Vec3 turned = times(c.H_W, {1, 2, 3});
    all.push_back(exchanged ? Seen{c.p_WC, p, -c.n_W, turned, c.distance, c.weight, c.stiffness}
                            : Seen{p, c.p_WC, c.n_W, turned, c.distance, c.weight, c.stiffness});
  }
  return all;
}

double difference(const Seen& a, const Seen& b) {
  return std::max({norm(a.on_body - b.on_body), norm(a.on_other - b.on_other), norm(a.n_W - b.n_W),
                   norm(a.turned - b.turned) / (1000 + norm(a.turned)), std::abs(a.distance - b.distance),
                   std::abs(a.weight - b.weight), std::abs(a.stiffness / b.stiffness - 1)});
}

void check_same(const std::vector<Seen>& a, std::vector<Seen> b) {
  BOOST_REQUIRE(a.size() == b.size());
  for (const Seen& contact : a) {
    const auto nearest = std::min_element(b.begin(), b.end(), [&](const Seen& x, const Seen& y) {
      return difference(contact, x) < difference(contact, y);
    });
    BOOST_TEST(difference(contact, *nearest) < 1e-9);
    b.erase(nearest);
  }
}

/// Poses of the tool near the origin, at which it touches what is about it.
std::vector<Pose> poses(int count, const Case& c) {
  std::vector<Pose> all;
  test::Dice dice(5);
  for (int i = 0; i < count; ++i) all.push_back(dice.pose(0.001, c.tool == "sphere" ? 3 : 0.3));
  return all;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_contact_has_a_unit_normal_between_its_points_and_every_body_is_met) {
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c) {
      const Scene scene = scene_about(tool_shape(c.tool));
      const auto node = node_of(c, scene);
      std::set<double> stiffnesses;
      for (const Pose& X_WT : poses(20, c)) {
        ContactSet set;
        node->query(X_WT, set);
        test::check_geometry(set);
        BOOST_TEST(set.truncated == 0);
        for (const Contact& contact : test::contacts_of(set)) stiffnesses.insert(contact.stiffness);
      }
      BOOST_TEST(stiffnesses.size() == 5U);
    }
  }
}

BOOST_AUTO_TEST_CASE(contacts_move_with_the_whole_scene) {
  const Pose X_VW{{0.3, -0.2, 0.15}, from_rotation_vector({0.7, -1.1, 0.4})};
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c) {
      const Scene scene = scene_about(tool_shape(c.tool));
      Scene moved = scene;
      for (Body& body : moved.bodies) body.X_WB = X_VW * body.X_WB;
      const auto node = node_of(c, scene), node_of_moved = node_of(c, moved);
      for (const Pose& X_WT : poses(10, c)) {
        ContactSet set, there;
        node->query(X_WT, set);
        node_of_moved->query(X_VW * X_WT, there);
        std::vector<Seen> expected = seen(set, false);
        for (std::size_t i = 0; i < expected.size(); ++i) {
          Seen& s = expected[i];
          s.on_body = transform(X_VW, s.on_body);
          s.on_other = transform(X_VW, s.on_other);
          s.n_W = rotate(X_VW.R, s.n_W);
          // H v in the one frame is R H R^T (R v) in the other.
          s.turned = rotate(X_VW.R, times(set.contact[i].H_W, rotate(inverse(X_VW.R), {1, 2, 3})));
        }
        BOOST_TEST(!expected.empty());
        check_same(expected, seen(there, false));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_depth_changes_by_no_more_than_the_way_moved_but_for_samples_that_come_to_face_away) {
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c) {
      const Scene scene = scene_about(tool_shape(c.tool));
      const auto node = node_of(c, scene);
      double last = 0, deepest = 0;
      Pose before;
      int jumps = 0;
      for (int i = 0; i < 1000; ++i) {
        const double t = 0.01 * i;
        const Pose X_WT{0.004 * Vec3{std::sin(t), std::sin(1.3 * t), std::cos(0.7 * t)},
                        from_rotation_vector({0.3 * std::sin(0.9 * t), 0.2 * std::cos(1.1 * t), 0.1 * t})};
        ContactSet set;
        node->query(X_WT, set);
        const double now = test::deepest(set, margin);
        const Quat turn = inverse(before.R) * X_WT.R;
        // No point of the tool is farther than 27 mm from its origin.
        const double way = norm(X_WT.p - before.p) + 0.027 * 2 * norm({turn.x, turn.y, turn.z});
        jumps += i > 0 && std::abs(now - last) > way + 1e-12 ? 1 : 0;
        last = now;
        before = X_WT;
        deepest = std::min(deepest, now);
      }
      BOOST_TEST(deepest < -0.001);
      // A sample of a box or a mesh whose nearest place moves on to another side of the body that it meets may face
      // away from that one. Balls face every way.
      BOOST_TEST(jumps <= (c.tool == "box" || c.tool == "mesh" ? 5 : 0));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_hessian_tells_how_normals_turn_as_the_tool_moves) {
  test::Dice dice(5);
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c) {
      const Scene scene = scene_about(tool_shape(c.tool));
      const auto node = node_of(c, scene);
      int compared = 0, off = 0;
      for (const Pose& X_WT : poses(20, c)) {
        ContactSet a, b;
        const Vec3 step = dice.in_cube(1e-8);
        node->query(X_WT, a);
        node->query({X_WT.p + step, X_WT.R}, b);
        if (a.count != b.count) continue;
        for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i) {
          const Contact &p = a.contact[i], &q = b.contact[i];
          // A step of 10 nm must be small against the radius of curvature.
          if (norm(times(p.H_W, step)) > 1e-4) continue;
          ++compared;
          BOOST_TEST(std::abs(q.distance - p.distance - dot(p.n_W, step)) < 1e-12);
          if (norm(q.n_W - p.n_W - times(p.H_W, step)) > 1e-9) ++off;
        }
      }
      BOOST_TEST(compared > 40);
      // Some step from one feature to another.
      BOOST_TEST(off <= compared / 50);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_order_of_the_bodies_does_not_matter) {
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c) {
      const Scene scene = scene_about(tool_shape(c.tool));
      Scene reversed = scene;
      std::reverse(reversed.bodies.begin(), reversed.bodies.end());
      const auto node = node_of(c, scene), other = node_of(c, reversed);
      for (const Pose& X_WT : poses(10, c)) {
        ContactSet a, b;
        node->query(X_WT, a);
        other->query(X_WT, b);
        check_same(seen(a, false), seen(b, false));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(two_moving_bodies_meet_the_same_whichever_is_the_tool) {
  const auto names = [](const std::string& kind) {
    return kind == "primitive" ? std::vector<std::string>{"sphere", "capsule", "box"}
                               : std::vector<std::string>{"sphere", "capsule", "box", "mesh"};
  };
  for (const std::string kind : {"exact", "sdf", "primitive"}) {
    for (const std::string& one : names(kind)) {
      for (const std::string& two : names(kind)) {
        BOOST_TEST_CONTEXT(kind << ": " << one << " and " << two) {
          Scene scene;
          scene.bodies = {test::shaped("one", tool_shape(one), Motion::rigid),
                          test::shaped("two", tool_shape(two), Motion::translation)};
          scene.bodies[1].X_WB.R = from_rotation_vector({0.5, 0.2, -0.3});
          scene.tool_name = "one";
          Scene exchanged = scene;
          exchanged.tool_name = "two";
          // Of one spacing, that of a box where there is one.
          const std::string spaced = two == "box" ? two : one;
          const auto node = node_of({kind, spaced}, scene), other = node_of({kind, spaced}, exchanged);
          test::Dice dice(5);
          int met = 0;
          for (int i = 0; i < 40; ++i) {
            BodyStates at, swapped;
            at.count = swapped.count = 2;
            at.X_WB[0] = swapped.X_WB[1] = dice.pose(0.005, 1);
            at.X_WB[1] = swapped.X_WB[0] = {{0.033 + dice(-0.004, 0.004), dice(-0.005, 0.005), dice(-0.005, 0.005)},
                                            scene.bodies[1].X_WB.R};
            ContactSet a, b;
            node->query(at, a);
            other->query(swapped, b);
            test::check_geometry(a);
            if (a.truncated == 0) check_same(seen(a, false), seen(b, true));
            met += a.penetrating > 0 ? 1 : 0;
            for (std::size_t k = 0; k < static_cast<std::size_t>(a.count); ++k) {
              BOOST_TEST(a.pair[k].body == 0);
              BOOST_TEST(a.pair[k].other == 1);
            }
          }
          BOOST_TEST(met > 10);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(what_is_found_does_not_depend_on_what_was_asked_before) {
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c) {
      const Scene scene = scene_about(tool_shape(c.tool), c.tool == "sphere" ? Motion::translation : Motion::rigid);
      const auto used = node_of(c, scene);
      test::Dice dice(5);
      Pose X_WT;
      for (int i = 0; i < 30; ++i) {
        // Small steps with a jump now and then.
        X_WT.p = i % 10 == 0 ? dice.in_cube(0.004) : X_WT.p + dice.in_cube(0.0005);
        if (c.tool != "sphere") X_WT.R = from_rotation_vector(dice.in_cube(0.02)) * X_WT.R;
        ContactSet a, b;
        used->query(X_WT, a);
        node_of(c, scene)->query(X_WT, b);
        // A choice among more contacts than a set holds remembers the last one.
        BOOST_REQUIRE(a.truncated == 0);
        BOOST_REQUIRE(a.count == b.count);
        for (std::size_t k = 0; k < static_cast<std::size_t>(a.count); ++k) {
          BOOST_TEST((a.contact[k].p_TC == b.contact[k].p_TC && a.contact[k].p_WC == b.contact[k].p_WC &&
                      a.contact[k].n_W == b.contact[k].n_W && a.contact[k].distance == b.contact[k].distance &&
                      a.contact[k].weight == b.contact[k].weight && a.contact[k].H_W == b.contact[k].H_W));
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_query_within_a_bound_of_work_finds_what_one_without_finds_or_changes_nothing) {
  for (const std::string tool : {"sphere", "capsule", "box", "mesh"}) {
    BOOST_TEST_CONTEXT(tool) {
      const Scene scene = scene_about(tool_shape(tool), tool == "sphere" ? Motion::translation : Motion::rigid);
      const ContactOptions options{.margin = margin, .spacing = tool == "box" || tool == "mesh" ? 0.012 : 0};
      const auto contacts = [&] { return SceneContacts(scene, options, cell_distances({.resolution = 24}, nullptr)); };
      SceneContacts bounded = contacts();
      test::Dice dice(11);
      BodyStates bodies;
      bodies.count = 1;
      Pose& X_WT = bodies.X_WB[0];
      ContactSet found, unbounded;
      int enough = 0, too_little = 0;
      for (int i = 0; i < 200; ++i) {
        // Small steps with a jump now and then.
        X_WT.p = i % 20 == 0 ? dice.in_cube(0.004) : X_WT.p + dice.in_cube(0.0003);
        if (tool != "sphere") X_WT.R = from_rotation_vector(dice.in_cube(0.02)) * X_WT.R;
        const int work = static_cast<int>(std::pow(10, dice(0, 3.5)));
        int used = 0;
        const auto before = std::make_unique<ContactSet>(found);
        if (!bounded.find_within(work, bodies, found, &used)) {
          ++too_little;
          BOOST_TEST(used == work);
          BOOST_REQUIRE(std::memcmp(before.get(), &found, sizeof found) == 0);
          continue;
        }
        ++enough;
        BOOST_TEST(used <= work);
        contacts().find(bodies, unbounded);
        // A choice among more contacts than a set holds remembers the last one.
        BOOST_REQUIRE(unbounded.truncated == 0);
        BOOST_REQUIRE(found.count == unbounded.count);
        for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
          const Contact &a = found.contact[k], &b = unbounded.contact[k];
          BOOST_TEST((a.p_TC == b.p_TC && a.p_WC == b.p_WC && a.n_W == b.n_W && a.distance == b.distance &&
                      a.weight == b.weight && a.H_W == b.H_W));
        }
      }
      BOOST_TEST(enough > 50);
      // A ball is one question a body, of which nobody counts the work.
      BOOST_TEST(too_little > (tool == "sphere" ? -1 : 20));
    }
  }
}

BOOST_AUTO_TEST_CASE(queries_allocate_nothing_once_they_have_met_the_most_contacts,
                     *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c) {
      // CGAL's search of all faces keeps its queue on the heap.
      if (c.kind == "exact") continue;
      const Scene scene = scene_about(tool_shape(c.tool));
      const auto node = node_of(c, scene);
      auto set = std::make_unique<ContactSet>();
      const std::vector<Pose> path = poses(50, c);
      for (const Pose& X_WT : path) node->query(X_WT, *set);
      const std::int64_t before = thread_heap_calls();
      for (const Pose& X_WT : path) node->query(X_WT, *set);
      BOOST_TEST(thread_heap_calls() == before);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_bounded_query_allocates_nothing_from_the_first_one_on,
                     *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  // A mesh of 10,242 vertices, all of which are inside the wall at once, and most of which are inside the rock.
  Scene scene;
  scene.bodies = {test::mesh_body("tool", test::icosphere(0.02, 5), Motion::rigid),
                  test::mesh_body("rock", test::icosphere(0.05, 2)), test::shaped("wall", BoxShape{{0.2, 0.2, 0.2}})};
  scene.bodies[1].X_WB.p = {0, 0, 0.02};
  scene.bodies[2].X_WB.p = {-0.1, 0, 0};
  SurfaceOptions options;
  options.margin = margin;
  options.max_contacts = 64;
  options.resolution = 24;
  const auto context = test::context_for(scene);
  for (const int work : {1, 1500, 5000, 1'000'000}) {
    BOOST_TEST_CONTEXT("work " << work) {
      options.most_work = work;
      const auto surface = surface_contacts(options, context);
      const auto set = std::make_unique<ContactSet>();
      BodyStates bodies;
      bodies.count = 1;
      int enough = 0, most = 0;
      // Inside the wall, deep and less so; then out of all.
      for (const double x : {-0.05, -0.05, -0.03, -0.01, 0.01, 0.018, 0.0195, 0.3, -0.04}) {
        bodies.X_WB[0].p = {x, 0, 0};
        const std::int64_t before = thread_heap_calls();
        const bool found = surface->find(bodies, *set);
        const std::int64_t calls = thread_heap_calls() - before;
        BOOST_TEST(calls == 0);
        enough += found ? 1 : 0;
        if (found) most = std::max(most, set->count + set->truncated);
      }
      if (work == 1) BOOST_TEST(enough == 1);
      if (work == 1'000'000) BOOST_TEST(enough == 9);
      // Those of the vertices that face what they are in.
      if (work == 1'000'000) BOOST_TEST(most > 8'000);
    }
  }
}

BOOST_AUTO_TEST_CASE(an_exact_query_and_one_by_cells_agree) {
  for (const std::string tool : {"mesh", "sphere", "capsule", "box"}) {
    BOOST_TEST_CONTEXT(tool) {
      const Scene scene = scene_about(tool_shape(tool));
      const auto exact = node_of({"exact", tool}, scene), cells = node_of({"sdf", tool}, scene);
      for (const Pose& X_WT : poses(20, {"exact", tool})) {
        ContactSet a, b;
        exact->query(X_WT, a);
        cells->query(X_WT, b);
        check_same(seen(a, false), seen(b, false));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(contacts_of_bodies_pressed_on_a_plane_are_those_of_their_closed_forms) {
  const auto set_at = [](const Shape& shape, const Pose& X_WT) {
    Scene scene;
    scene.bodies = {test::shaped("floor", PlaneShape{}), test::shaped("tool", shape, Motion::rigid)};
    for (Body& b : scene.bodies) b.material = {.stiffness = 2000, .damping = 2, .friction = 0.3, .patch_area = 1e-4};
    auto set = std::make_unique<ContactSet>();
    made<PrimitiveCollision>(scene)->query(X_WT, *set);
    test::check_geometry(*set);
    return set;
  };
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-9 * (1 + std::abs(b)); };
  // 1000 N/m for weight 1, 0.5 mm deep.
  const auto ball = set_at(SphereShape{0.01}, {{0.2, 0, 0.0095}, {}});
  BOOST_TEST(near(test::spring_wrench(*ball).force.z, 0.5));
  const CapsuleShape rod{.radius = 0.01, .length = 0.06};
  // On its end a capsule is the ball it ends in; lying, it carries 2 + L / (2 r) times as much, in balance.
  const auto standing = set_at(rod, {{0.2, 0, 0.0395}, {}});
  BOOST_TEST(near(test::spring_wrench(*standing).force.z, 0.5));
  const auto lying = set_at(rod, {{0, 0, 0.0095}, from_rotation_vector({std::numbers::pi / 2, 0, 0})});
  BOOST_TEST(near(test::spring_wrench(*lying).force.z, 0.5 * 5));
  BOOST_TEST(norm(test::spring_wrench(*lying).torque) < 1e-12);
  // A box of 40 x 20 mm has 8 patches; a thousandth and a bit is added of the strip of the sides that the rim stands
  // for.
  const auto box = set_at(BoxShape{{0.04, 0.02, 0.01}}, {{0, 0, 0.0045}, {}});
  const double rim = 2 * (0.04 + 0.02) * 0.0025;
  BOOST_TEST(near(test::spring_wrench(*box).force.z, 0.5 * (0.04 * 0.02 + rim * 0.001 / 1.001) / 1e-4));
  BOOST_TEST(norm(test::spring_wrench(*box).torque) < 1e-12);
  // On its edge, tilted by 45 degrees, the depth is still exact.
  const auto edge = set_at(BoxShape{{0.04, 0.02, 0.02}}, {{0, 0, std::sqrt(2.0) * 0.01 - 0.0005},
                                                          from_rotation_vector({std::numbers::pi / 4, 0, 0})});
  BOOST_TEST(near(test::deepest(*edge, margin), -0.0005));
}

BOOST_AUTO_TEST_SUITE_END()
