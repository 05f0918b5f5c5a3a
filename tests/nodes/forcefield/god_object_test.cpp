// The proxy on surfaces: where it must be by closed forms, what holds it, and what it never gets through.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "nodes/forcefield/god_object.hpp"
#include "nodes/physics/geometry/tree_distance.hpp"
#include "tests/nodes/forcefield/field_scenes.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(god_object_test)

using namespace tactor;
using namespace tactor::test;

namespace {

/// m: a point stands so far above a surface, and a move ends so near to rest.
constexpr double skin = 2e-7;

Scene scene_with(std::vector<Body> fixed, double friction = 0) {
  Scene scene;
  scene.bodies = std::move(fixed);
  scene.bodies.push_back(field_body("tool", SphereShape{0.004}, Motion::translation));
  for (Body& body : scene.bodies) body.material.friction = friction;
  return scene;
}

Body mesh_body(const TriangleMesh& mesh, const std::string& name) {
  return field_body(name, MeshShape{write_off(mesh, name)});
}

/// The half-space below the plane through `p` with the outward normal n.
Body plane_body(const std::string& name, const Vec3& p, const Vec3& n) {
  Body body = field_body(name, PlaneShape{});
  const Vec3 axis = cross({0, 0, 1}, n);
  const double sine = norm(axis), angle = std::atan2(sine, n.z);
  body.X_WB = {p, from_rotation_vector(sine > 0 ? (angle / sine) * axis : Vec3{angle, 0, 0})};
  return body;
}

GodObject proxy_in(const Scene& scene, double radius = 0, double crease = 0.6, bool friction = true) {
  return GodObject(
      scene, {.radius = radius, .friction = friction, .crease = crease, .most_casts = 1000, .most_looks = 1'000'000},
      nullptr);
}

/// Goes from where the handle was to `to` in steps of at most 0.5 mm.
void walk(GodObject& proxy, const Vec3& from, const Vec3& to) {
  const int steps = std::max(1, static_cast<int>(norm(to - from) / 5e-4));
  for (int i = 1; i <= steps; ++i) proxy.move(from + (static_cast<double>(i) / steps) * (to - from));
}

/// A beam along y whose section is an L: legs 40 mm long and 10 mm wide, the inside edge at x = z = 0.
TriangleMesh angle_beam() {
  const double a = 0.03, w = 0.01, y = 0.05;
  const std::vector<std::pair<double, double>> section{{-w, -w}, {a, -w}, {a, 0}, {0, 0}, {0, a}, {-w, a}};
  TriangleMesh mesh;
  for (const double side : {-y, y}) {
    for (const auto& [x, z] : section) mesh.vertices.push_back({x, side, z});
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.faces.push_back({i, i + 6, j});
    mesh.faces.push_back({j, i + 6, j + 6});
  }
  for (const auto& [p, q, r] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}) {
    mesh.faces.push_back({p, q, r});
    mesh.faces.push_back({p + 6, r + 6, q + 6});
  }
  return mesh;
}

/// The point of the intersection of half-spaces that is nearest to `goal`, by Dykstra's alternating projections.
Vec3 nearest_by_projections(const std::vector<std::pair<Vec3, Vec3>>& planes, const Vec3& goal) {
  Vec3 x = goal;
  std::vector<Vec3> kept(planes.size());
  for (int sweep = 0; sweep < 20000; ++sweep) {
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const auto& [p, n] = planes[i];
      const Vec3 y = x + kept[i];
      x = y - std::min(0.0, dot(n, y - p)) * n;
      kept[i] = y - x;
    }
  }
  return x;
}

}  // namespace

BOOST_AUTO_TEST_CASE(on_a_plane_the_proxy_stands_above_the_handle) {
  const Vec3 n = Vec3{1, 2, 3} / norm({1, 2, 3});
  GodObject proxy = proxy_in(scene_with({plane_body("wall", {0.01, 0, 0}, n)}));
  const Vec3 on{0.01, 0, 0};
  const Vec3 above = on + 0.01 * n;
  proxy.move(above);
  BOOST_TEST(norm(proxy.stretch(false)) == 0.0);
  for (const double depth : {1e-5, 1e-3, 0.02}) {
    const Vec3 handle = on - depth * n + cross(n, {1, 0, 0}) * (3 * depth);
    proxy.move(handle);
    BOOST_TEST(norm(proxy.stretch(false) - depth * n) < skin);
    BOOST_TEST(proxy.contacts() == 1);
    BOOST_TEST(std::abs(proxy.normal_stretch() - depth) < skin);
  }
  proxy.move(above);
  BOOST_TEST(norm(proxy.stretch(false)) == 0.0);
  BOOST_TEST(proxy.contacts() == 0);
}

BOOST_AUTO_TEST_CASE(friction_holds_within_its_cone_and_slides_at_its_edge) {
  const double mu = 0.5, depth = 0.002;
  GodObject proxy = proxy_in(scene_with({plane_body("floor", {}, {0, 0, 1})}, mu));
  proxy.move({0, 0, 0.01});
  proxy.move({0, 0, -depth});
  // Within the cone nothing slips: back and forth leave no trace.
  for (const double x : {0.2e-3, 0.9e-3, -0.9e-3, 0.5e-3}) {
    proxy.move({x, 0, -depth});
    BOOST_TEST(norm(proxy.stretch(false) - Vec3{-x, 0, depth}) < skin);
  }
  // Beyond it the force keeps to the edge of the cone, against the motion.
  for (const double x : {1.5e-3, 3e-3, 10e-3}) {
    proxy.move({x, 0, -depth});
    BOOST_TEST(norm(proxy.stretch(false) - Vec3{-mu * depth, 0, depth}) < 2 * skin);
  }
  // On the way back it sticks until the other edge of the cone.
  proxy.move({10e-3 - 1.9 * mu * depth, 0, -depth});
  BOOST_TEST(norm(proxy.stretch(false) - Vec3{0.9 * mu * depth, 0, depth}) < 2 * skin);
  proxy.move({5e-3, 1e-3, -depth});
  const Vec3 stretch = proxy.stretch(false);
  BOOST_TEST(std::abs(std::hypot(stretch.x, stretch.y) - mu * depth) < 2 * skin);
  // A handle that is pulled up lets it slip, for the cone is narrower there.
  proxy.move({5e-3, 1e-3, -depth / 4});
  const Vec3 lighter = proxy.stretch(false);
  BOOST_TEST(std::abs(std::hypot(lighter.x, lighter.y) - mu * depth / 4) < 2 * skin);
}

BOOST_AUTO_TEST_CASE(in_a_groove_both_sides_hold_by_friction) {
  // Sides at 30 degrees from the vertical: a handle d below the edge is pushed by d / (2 sin 30) on either side.
  const double half = std::numbers::pi / 6, mu = 0.2, depth = 0.003;
  const Scene scene = scene_with({plane_body("left", {}, {std::cos(half), 0, std::sin(half)}),
                                  plane_body("right", {}, {-std::cos(half), 0, std::sin(half)})},
                                 mu);
  GodObject proxy = proxy_in(scene);
  proxy.move({0, 0, 0.01});
  walk(proxy, {0, 0, 0.01}, {0, 0, -depth});
  BOOST_TEST(proxy.contacts() == 2);
  const double each = depth / (2 * std::sin(half));
  BOOST_TEST(std::abs(proxy.normal_stretch() - 2 * each) < 4 * skin);
  walk(proxy, {0, 0, -depth}, {0, 0.02, -depth});
  BOOST_TEST(norm(proxy.stretch(false) - Vec3{0, -mu * 2 * each, depth}) < 4 * skin);
}

BOOST_AUTO_TEST_CASE(between_oblique_planes_it_is_the_nearest_point_that_all_allow) {
  Dice dice(4);
  int two = 0, three = 0;
  for (int n = 0; n < 40; ++n) {
    std::vector<std::pair<Vec3, Vec3>> planes;
    std::vector<Body> bodies;
    for (int i = 0; i < 3; ++i) {
      Vec3 normal = dice.in_cube(1);
      normal.z = std::abs(normal.z) + 0.3;
      planes.emplace_back(dice.in_cube(0.002), normal / norm(normal));
      bodies.push_back(plane_body("plane" + std::to_string(i), planes.back().first, planes.back().second));
    }
    GodObject proxy = proxy_in(scene_with(bodies));
    Vec3 handle{0, 0, 0.05};
    proxy.move(handle);
    for (int k = 0; k < 10; ++k) {
      const Vec3 next = dice.in_cube(0.01) + Vec3{0, 0, -0.006};
      walk(proxy, handle, next);
      handle = next;
      const Vec3 x = nearest_by_projections(planes, handle);
      BOOST_TEST(norm(proxy.position() - x) < 3e-6);
      two += proxy.contacts() == 2 ? 1 : 0;
      three += proxy.contacts() == 3 ? 1 : 0;
    }
  }
  BOOST_TEST(two > 50);
  BOOST_TEST(three > 20);
}

BOOST_AUTO_TEST_CASE(the_inside_edge_of_a_mesh_holds_it) {
  for (const double radius : {0.0, 0.002}) {
    GodObject proxy = proxy_in(scene_with({mesh_body(angle_beam(), "beam")}), radius);
    const double r = std::max(radius, GodObject::point_radius);
    Vec3 handle{0.01, 0, 0.01};
    proxy.move(handle);
    // Deep through both legs, and along the edge.
    for (const Vec3& next : {Vec3{0.005, 0, -0.02}, Vec3{-0.02, 0, -0.02}, Vec3{-0.02, 0.03, -0.005},
                             Vec3{-0.004, -0.03, -0.03}, Vec3{-0.03, 0.01, 0.02}, Vec3{0.02, 0.01, -0.03}}) {
      walk(proxy, handle, next);
      handle = next;
      BOOST_TEST(norm(proxy.position() - Vec3{std::max(next.x, r), next.y, std::max(next.z, r)}) < skin);
    }
  }
}

BOOST_AUTO_TEST_CASE(it_goes_round_an_outside_edge) {
  GodObject proxy = proxy_in(scene_with({field_body("block", BoxShape{{0.04, 0.04, 0.04}})}));
  Vec3 handle{0, 0, 0.03};
  proxy.move(handle);
  walk(proxy, handle, {0, 0, 0.018});
  BOOST_TEST(norm(proxy.position() - Vec3{0, 0, 0.02}) < skin);
  // Out over the edge, and down beside it.
  walk(proxy, {0, 0, 0.018}, {0.03, 0, 0.018});
  BOOST_TEST(norm(proxy.position() - Vec3{0.03, 0, 0.018}) < skin);
  walk(proxy, {0.03, 0, 0.018}, {0.03, 0, 0.005});
  walk(proxy, {0.03, 0, 0.005}, {0.015, 0.001, 0.005});
  BOOST_TEST(norm(proxy.position() - Vec3{0.02, 0.001, 0.005}) < skin);
}

BOOST_AUTO_TEST_CASE(on_balls_it_is_the_nearest_point_of_a_radial_push) {
  const double R = 0.03;
  Dice dice(6);
  const Scene round = scene_with({field_body("ball", SphereShape{R})});
  // The facets of an icosphere lie inside of the sphere: by their sagitta, at which their normals meet them.
  const TriangleMesh facets = icosphere(R, 3);
  const Scene faceted = scene_with({mesh_body(facets, "facets")});
  double nearest_plane = R;
  for (const auto& f : facets.faces) {
    const Vec3 n = doubled_area_normal(facets, f);
    nearest_plane = std::min(nearest_plane, dot(n, facets.vertices[static_cast<std::size_t>(f[0])]) / norm(n));
  }
  const double facet_angle = std::acos(nearest_plane / R);  // between a face's normal and its corners
  for (int n = 0; n < 30; ++n) {
    Vec3 out = dice.in_cube(1);
    out = out / norm(out);
    const double depth = dice(1e-4, 0.02);
    GodObject smooth = proxy_in(round), rough = proxy_in(faceted);
    for (GodObject* proxy : {&smooth, &rough}) {
      proxy->move(1.2 * R * out);
      walk(*proxy, 1.2 * R * out, (R - depth) * out);
    }
    BOOST_TEST(norm(smooth.position() - R * out) < skin);
    const Vec3 p = rough.position();
    BOOST_TEST(norm(p) <= R + skin);
    BOOST_TEST(norm(p) >= nearest_plane);
    // Its direction is that of a facet; shaded, it is radial but for the corners' normals, which are means of facets.
    const Vec3 flat = rough.stretch(false), shaded = rough.stretch(true);
    if (depth > 2e-3) {
      BOOST_TEST(norm(cross(flat / norm(flat), out)) < std::sin(1.001 * facet_angle));
      BOOST_TEST(std::abs(norm(shaded) - rough.normal_stretch()) < 1e-2 * rough.normal_stretch());
      const Vec3 radial = p / norm(p);
      BOOST_TEST(norm(cross(shaded / norm(shaded), radial)) < 0.25 * facet_angle);
    }
  }
}

BOOST_AUTO_TEST_CASE(over_fine_facets_it_slides_and_never_rests_behind_the_handle) {
  // Neighbours that fold by fractions of a degree, met one after another: the ball follows the handle all round.
  const double R = 0.03, r = 0.004;
  GodObject proxy = proxy_in(scene_with({mesh_body(icosphere(R, 4), "fine")}), r);
  const Vec3 a = Vec3{1, 0.3, 0.2} / norm({1, 0.3, 0.2}), c = cross(a, {0, 0.6, 0.8}), b = c / norm(c);
  proxy.move(1.3 * R * a);
  double farthest = 0;
  for (int i = 0; i <= 5000; ++i) {
    const double angle = i * 1e-3;
    const Vec3 out = std::cos(angle) * a + std::sin(angle) * b;
    proxy.move((0.8 * R + 0.1 * R * std::sin(7 * angle)) * out);
    const Vec3 p = proxy.position();
    if (i > 0) farthest = std::max(farthest, norm(cross(p / norm(p), out)));
    BOOST_REQUIRE(std::abs(norm(p) - R - r) < 5e-5);
  }
  // A face's corner is 2 degrees from its middle; the nearest point of facets may be that far off.
  BOOST_TEST(farthest < 0.04);
}

BOOST_AUTO_TEST_CASE(shading_makes_the_force_on_facets_turn_without_steps) {
  const double R = 0.03;
  const Scene faceted = scene_with({mesh_body(icosphere(R, 2), "coarse")});
  double flat_step = 0, shaded_step = 0;
  GodObject proxy = proxy_in(faceted);
  Vec3 last_flat, last_shaded;
  for (int i = 0; i <= 4000; ++i) {
    const double angle = 1e-3 * i * 0.5;
    const Vec3 out{std::cos(angle), std::sin(angle) * std::cos(0.3), std::sin(angle) * std::sin(0.3)};
    if (i == 0) proxy.move(1.1 * R * out);
    proxy.move(0.95 * R * out);
    const Vec3 flat = proxy.stretch(false) / norm(proxy.stretch(false));
    const Vec3 shaded = proxy.stretch(true) / norm(proxy.stretch(true));
    if (i > 0) {
      flat_step = std::max(flat_step, norm(flat - last_flat));
      shaded_step = std::max(shaded_step, norm(shaded - last_shaded));
    }
    last_flat = flat;
    last_shaded = shaded;
  }
  BOOST_TEST_MESSAGE("largest turn of the force a step, rad: " << flat_step << " flat, " << shaded_step << " shaded");
  BOOST_TEST(flat_step > 0.05);
  BOOST_TEST(shaded_step < 0.2 * flat_step);
}

BOOST_AUTO_TEST_CASE(sharp_edges_are_not_shaded) {
  GodObject proxy = proxy_in(scene_with({field_body("block", BoxShape{{0.04, 0.04, 0.04}})}));
  proxy.move({0.019, 0.018, 0.03});
  walk(proxy, {0.019, 0.018, 0.03}, {0.019, 0.018, 0.015});
  BOOST_TEST(norm(proxy.stretch(true) - Vec3{0, 0, 0.005}) < skin);
}

BOOST_AUTO_TEST_CASE(nothing_gets_through_a_thin_wall) {
  for (const double radius : {0.0, 0.003}) {
    const Scene scene = scene_with({mesh_body(box({0.1, 0.1, 5e-5}), "sheet")});
    GodObject proxy = proxy_in(scene, radius);
    const double height = 2.5e-5 + std::max(radius, GodObject::point_radius);
    Dice dice(8);
    proxy.move({0, 0, 0.01});
    // At once, 20 mm through, without a step between; then about behind it.
    for (int n = 0; n < 2000; ++n) {
      const Vec3 handle{dice(-0.04, 0.04), dice(-0.04, 0.04), dice(-0.02, n % 5 == 0 ? 0.01 : 0)};
      proxy.move(handle);
      BOOST_REQUIRE(proxy.position().z > height - 1e-9);
      BOOST_TEST(norm(proxy.position() - Vec3{handle.x, handle.y, std::max(handle.z, height)}) < skin);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_random_walk_never_enters_a_mesh_and_each_move_comes_nearer) {
  const std::vector<TriangleMesh> meshes{icosphere(0.02, 2), angle_beam(), box({0.03, 0.02, 0.0005})};
  int n = 0;
  for (const TriangleMesh& mesh : meshes) {
    const TreeDistance distance(mesh);
    for (const double radius : {0.0, 0.002}) {
      for (const double friction : {0.0, 0.4}) {
        GodObject proxy = proxy_in(scene_with({mesh_body(mesh, "walked" + std::to_string(n++))}, friction), radius);
        const double least = std::max(radius, GodObject::point_radius) - 1e-9;
        Dice dice(static_cast<std::uint64_t>(n));
        Vec3 handle{0, 0, 0.06};
        proxy.move(handle);
        for (int k = 0; k < 3000; ++k) {
          handle = k % 50 == 0 ? dice.in_cube(0.04) : handle + dice.in_cube(0.002);
          const double before = norm(proxy.position() - handle);
          proxy.move(handle);
          BOOST_REQUIRE(distance.nearest(proxy.position()).distance >= least);
          BOOST_REQUIRE(norm(proxy.position() - handle) <= before + 1e-12);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_start_deep_inside_finds_the_surface) {
  const double R = 0.02;
  for (const Scene& scene :
       {scene_with({field_body("ball", SphereShape{R})}), scene_with({mesh_body(icosphere(R, 3), "deep")})}) {
    GodObject proxy = proxy_in(scene);
    proxy.move({0.001, 0.002, 0.012});
    BOOST_TEST(!proxy.lost());
    BOOST_TEST(std::abs(norm(proxy.position()) - R) < 2e-4);
    BOOST_TEST(proxy.contacts() >= 1);
    BOOST_TEST(dot(proxy.stretch(false), {0.001, 0.002, 0.012}) > 0.0);
  }
  // Of two bodies that overlap the proxy is outside of both.
  const Scene two = scene_with({field_body("block", BoxShape{{0.04, 0.04, 0.04}}), plane_body("floor", {}, {0, 0, 1})});
  GodObject proxy = proxy_in(two);
  proxy.move({0.015, 0, -0.005});
  BOOST_TEST(!proxy.lost());
  BOOST_TEST(proxy.position().z >= 0.0);
  BOOST_TEST(std::max(std::abs(proxy.position().x), proxy.position().z) >= 0.02);
}

BOOST_AUTO_TEST_CASE(without_a_place_outside_it_is_lost_until_there_is_one) {
  // Two half-spaces that leave nothing between them about z = 0.
  Scene scene =
      scene_with({plane_body("below", {0, 0, 0.01}, {0, 0, 1}), plane_body("above", {0, 0, -0.01}, {0, 0, -1})});
  GodObject proxy = proxy_in(scene);
  proxy.move({0, 0, 0});
  BOOST_TEST(proxy.lost());
  BOOST_TEST(norm(proxy.stretch(true)) == 0.0);
}

BOOST_AUTO_TEST_CASE(a_lost_proxy_asks_for_a_few_nearest_points_a_move_and_finds_its_way_out) {
  // Two slabs that overlap by 20 mm: each pushes the ball back into the other.
  Body upper = field_body("upper", BoxShape{{0.1, 0.1, 0.05}}), lower = field_body("lower", BoxShape{{0.1, 0.1, 0.05}});
  upper.X_WB.p.z = 0.015;
  lower.X_WB.p.z = -0.015;
  GodObject proxy = proxy_in(scene_with({upper, lower}), 0.002);
  int queries = 0;
  for (int i = 0; i < 400; ++i) {
    proxy.move({0, 0, 1e-3});
    BOOST_REQUIRE(proxy.lost());
    BOOST_REQUIRE(norm(proxy.stretch(true)) == 0.0);
    BOOST_REQUIRE(norm(proxy.position() - Vec3{0, 0, 1e-3}) == 0.0);
    BOOST_REQUIRE(proxy.queries() > 0);
    BOOST_REQUIRE(proxy.queries() <= 2 * 8);
    queries += proxy.queries();
  }
  BOOST_TEST(queries > 400);
  int moves = 0;
  for (; moves < 100 && proxy.lost(); ++moves) proxy.move({0, 0, 0.06});
  BOOST_TEST(moves <= 26);
  for (int i = 0; i < 3; ++i) proxy.move({0, 0, 0.06});
  BOOST_TEST(norm(proxy.position() - Vec3{0, 0, 0.06}) == 0.0);
  BOOST_TEST(proxy.queries() == 0);
}

BOOST_AUTO_TEST_CASE(what_most_looks_ends_goes_on_at_the_next_move) {
  const double R = 0.02, r = 0.002;
  const TriangleMesh mesh = icosphere(R, 4);
  const TreeDistance distance(mesh);
  const Scene scene = scene_with({mesh_body(mesh, "facets4")});
  constexpr int looks = 800;
  GodObject few(scene, {.radius = r, .crease = 0.6, .most_casts = 1000, .most_looks = looks}, nullptr);
  GodObject many = proxy_in(scene, r);
  Dice dice(9);
  int starved = 0;
  few.move({0, 0, 0.04});
  many.move({0, 0, 0.04});
  for (int goal = 0; goal < 10; ++goal) {
    const Vec3 handle = dice.in_cube(0.5 * R) + Vec3{0, 0, goal % 2 == 0 ? R : 0.1 * R};
    double before = norm(few.position() - handle);
    for (int i = 0; i < 1500; ++i) {
      few.move(handle);
      many.move(handle);
      starved += few.starved() ? 1 : 0;
      BOOST_REQUIRE(few.looked() < looks + 8);
      BOOST_REQUIRE(distance.nearest(few.position()).distance >= r - 1e-9);
      BOOST_REQUIRE(norm(few.position() - handle) <= before + 1e-12);
      before = norm(few.position() - handle);
    }
    BOOST_TEST(!many.starved());
    BOOST_TEST(norm(few.position() - many.position()) < 1e-4);
  }
  BOOST_TEST(starved > 10);
}

BOOST_AUTO_TEST_CASE(what_most_casts_ends_goes_on_at_the_next_move) {
  const Scene scene = scene_with({mesh_body(icosphere(0.02, 3), "facets2")});
  GodObject few(scene, {.crease = 0.6, .most_casts = 4, .most_looks = 1'000'000}, nullptr);
  GodObject many = proxy_in(scene);
  for (GodObject* proxy : {&few, &many}) {
    proxy->move({0, 0, 0.03});
    proxy->move({0.008, 0.002, 0.005});
  }
  BOOST_TEST(few.casts() <= 4);
  for (int i = 0; i < 200; ++i) few.move({0.008, 0.002, 0.005});
  BOOST_TEST(norm(few.position() - many.position()) < 1e-5);
}

BOOST_AUTO_TEST_CASE(a_move_calls_no_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  GodObject proxy = proxy_in(
      scene_with({mesh_body(icosphere(0.02, 3), "facets3"), field_body("capsule", CapsuleShape{0.005, 0.03})}));
  Dice dice(3);
  proxy.move({0, 0, 0.05});
  const std::int64_t before = thread_heap_calls();
  for (int i = 0; i < 500; ++i) proxy.move(dice.in_cube(0.03));
  BOOST_TEST(thread_heap_calls() - before == 0);
}

BOOST_AUTO_TEST_SUITE_END()
