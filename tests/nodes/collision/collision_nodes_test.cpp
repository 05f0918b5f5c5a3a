// The contacts of the collision nodes: geometry, weights, materials, capacity, refusals.
#include <boost/test/unit_test.hpp>

#include "nodes/collision/auto.hpp"
#include "nodes/collision/exact.hpp"
#include "nodes/collision/none.hpp"
#include "nodes/collision/primitive.hpp"
#include "nodes/collision/sdf.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"

BOOST_AUTO_TEST_SUITE(collision_nodes_test)

using namespace tactor;
using test::ball;
using test::check_geometry;
using test::mesh_body;
namespace tt = boost::test_tools;

namespace {

/// Coarse cells are soon made.
SdfCollision::Params coarse_params() {
  auto params = test::default_params<SdfCollision>();
  params.resolution = 24;
  return params;
}

double total_stiffness(const ContactSet& set) {
  double sum = 0;
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    if (c.distance < 0) sum += c.weight * c.stiffness;
  }
  return sum;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_sphere_on_a_block_has_one_contact_below_it) {
  Scene scene;
  scene.bodies = {mesh_body("block", test::box({0.1, 0.1, 0.02})), ball("tool", 0.01, Motion::rigid)};
  scene.bodies[0].X_WB = {{0.2, 0, 0.3}, from_rotation_vector({0, 0, 0.4})};
  scene.bodies[0].material = {.stiffness = 3000, .damping = 5, .friction = 0.4};
  scene.bodies[1].material = {.stiffness = 1500, .damping = 2, .friction = 0.1};
  PrimitiveCollision node(test::default_params<PrimitiveCollision>(), test::context_for(scene));
  ContactSet set;
  node.query({{0.21, 0.005, 0.3195}, from_rotation_vector({1, 2, 0.5})}, set);
  BOOST_REQUIRE(set.count == 1);
  BOOST_TEST(set.penetrating == 1);
  check_geometry(set);
  const Contact& c = set.contact[0];
  BOOST_TEST(c.distance == -0.0005, tt::tolerance(1e-9));
  BOOST_TEST(norm(c.n_W - Vec3{0, 0, 1}) < 1e-12);
  BOOST_TEST(norm(c.p_WC - Vec3{0.21, 0.005, 0.31}) < 1e-12);
  BOOST_TEST(c.stiffness == 1000.0, tt::tolerance(1e-12));
  BOOST_TEST(c.damping == 2.0);
  BOOST_TEST(c.friction == 0.2, tt::tolerance(1e-12));
  BOOST_TEST(c.weight == 1.0);
}

BOOST_AUTO_TEST_CASE(contacts_are_reported_within_the_margin_and_not_beyond) {
  Scene scene;
  scene.bodies = {ball("fixed", 0.05), ball("tool", 0.01, Motion::translation)};
  PrimitiveCollision node(test::default_params<PrimitiveCollision>(), test::context_for(scene));
  ContactSet set;
  for (const auto& [x, count, penetrating] :
       {std::tuple{0.0625, 0, 0}, std::tuple{0.0615, 1, 0}, std::tuple{0.059, 1, 1}, std::tuple{0.0, 1, 1}}) {
    node.query({{x, 0, 0}, {}}, set);
    BOOST_TEST(set.count == count);
    BOOST_TEST(set.penetrating == penetrating);
    check_geometry(set);
  }
}

BOOST_AUTO_TEST_CASE(a_sphere_that_moves_meets_what_a_fresh_query_meets) {
  Scene scene;
  scene.bodies = {mesh_body("rock", test::icosphere(0.05, 2)), ball("tool", 0.01, Motion::translation)};
  const auto params = test::default_params<PrimitiveCollision>();
  PrimitiveCollision node(params, test::context_for(scene)), fresh(params, test::context_for(scene));
  for (int i = 0; i < 400; ++i) {
    ContactSet a, b;
    const Pose X{{0.09 * std::cos(0.05 * i), 0.06 * std::sin(0.07 * i), 0.01}, {}};
    node.query(X, a);
    fresh.query({{1, 1, 1}, {}}, b);
    fresh.query(X, b);
    BOOST_REQUIRE(a.count == b.count);
    if (a.count == 1) BOOST_TEST(std::abs(a.contact[0].distance - b.contact[0].distance) < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(a_block_pressed_flat_on_a_block_has_the_stiffness_of_its_area) {
  Scene scene;
  scene.bodies = {mesh_body("table", test::box({0.1, 0.1, 0.02})),
                  mesh_body("block", test::box({0.04, 0.04, 0.04}), Motion::rigid)};
  for (Body& b : scene.bodies) b.material = {.stiffness = 4000, .damping = 2, .friction = 0.3, .patch_area = 1e-4};
  SdfCollision::Params p = coarse_params();
  p.margin = 0.0002;
  for (const double spacing : {0.006, 0.003}) {
    p.spacing = spacing;
    SdfCollision node(p, test::context_for(scene));
    ContactSet set;
    node.query({{0.003, 0.001, 0.0295}, {}}, set);
    check_geometry(set);
    BOOST_TEST((set.truncated > 0) == (spacing < 0.005));
    // Series of the two: 2000 N/m a patch, 16 patches, of the samples of the block. Those of the table below it, half
    // of all, have the area of a few more or less as it lies.
    BOOST_TEST(total_stiffness(set) == 2000 * 16, tt::tolerance(0.03));
    // Samples nearer to the side than to the bottom push aside; the others push up.
    int up = 0;
    for (int i = 0; i < set.count; ++i) {
      const Contact& c = set.contact[static_cast<std::size_t>(i)];
      up += c.distance < 0 && c.n_W.z > 1 - 1e-9 ? 1 : 0;
    }
    BOOST_TEST(up > 0.9 * set.penetrating);
  }
}

BOOST_AUTO_TEST_CASE(contact_is_found_from_either_side) {
  // The tool's only vertices are far from where the spike of the fixed body enters its face.
  TriangleMesh spike = test::box({0.02, 0.02, 0.02});
  for (const std::size_t i : {4U, 5U, 6U, 7U})
    spike.vertices[i] = {1e-4 * spike.vertices[i].x, 1e-4 * spike.vertices[i].y, 0.03};
  Scene scene;
  scene.bodies = {mesh_body("spike", spike), mesh_body("slab", test::box({0.2, 0.2, 0.02}), Motion::rigid)};
  SdfCollision node(coarse_params(), test::context_for(scene));
  ContactSet set;
  node.query({{0.03, -0.02, 0.0395}, {}}, set);
  BOOST_TEST(set.penetrating == 4);
  check_geometry(set);
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    // The points of the spike's sides that are within the margin do not touch.
    if (c.distance > 0) continue;
    BOOST_TEST(c.distance == -0.0005, tt::tolerance(1e-6));
    BOOST_TEST(norm(c.n_W - Vec3{0, 0, 1}) < 1e-9);
    BOOST_TEST(norm(transform(set.bodies.X_WB[0], c.p_TC) - Vec3{c.p_WC.x, c.p_WC.y, 0.0295}) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(a_full_set_has_the_wrench_of_all_contacts_however_few_it_keeps) {
  Scene scene;
  const TriangleMesh rock = test::icosphere(0.05, 4);
  scene.bodies = {test::shaped("floor", PlaneShape{}), mesh_body("rock", rock, Motion::rigid)};
  const Pose X_WT{{0.01, 0, 0.042}, from_rotation_vector({0.01, 0.02, 0})};
  auto params = coarse_params();
  params.margin = 0;
  Wrench all;
  for (const int most : {128, 60, 20}) {
    params.max_contacts = most;
    SdfCollision node(params, test::context_for(scene));
    ContactSet set;
    node.query(X_WT, set);
    check_geometry(set);
    BOOST_REQUIRE(set.count == std::min(most, 128));
    const Wrench wrench = test::spring_wrench(set);
    if (most == 128) {
      BOOST_TEST(norm(wrench.force) > 0.1);
      BOOST_TEST(set.truncated > 0);
      // Each vertex of the rock below the floor, which has no samples, presses by its area as seen from there, and
      // depth.
      for (const SurfaceSample& s : vertex_samples(rock).points) {
        const Vec3 x = transform(X_WT, s.p);
        if (x.z >= 0) continue;
        const double area = s.area * std::max(0.0, -rotate(X_WT.R, s.normal).z);
        const Vec3 force{0, 0, -1000 * area / 1e-4 * x.z};
        all.force += force;
        all.torque += cross({x.x, x.y, 0}, force);
      }
    }
    BOOST_TEST(norm(wrench.force - all.force) < 1e-3 * norm(all.force));
    BOOST_TEST(norm(wrench.torque - all.torque) < 1e-3 * norm(all.force) * 0.05);
  }
}

BOOST_AUTO_TEST_CASE(contact_forces_change_smoothly_as_samples_come_and_go) {
  Scene scene;
  scene.bodies = {mesh_body("rock", test::icosphere(0.05, 4)),
                  mesh_body("tool", test::icosphere(0.03, 3), Motion::rigid)};
  SdfCollision node(coarse_params(), test::context_for(scene));
  double last = 0, largest = 0, step = 0;
  for (int i = 0; i < 4000; ++i) {
    ContactSet set;
    const double angle = 1e-4 * i;
    node.query({{0.078 * std::cos(angle), 0.078 * std::sin(angle), 0.01}, {}}, set);
    Vec3 force;
    for (int k = 0; k < set.count; ++k) {
      const Contact& c = set.contact[static_cast<std::size_t>(k)];
      if (c.distance < 0) force -= c.stiffness * c.weight * c.distance * c.n_W;
    }
    const double now = norm(force);
    if (i > 0) step = std::max(step, std::abs(now - last));
    largest = std::max(largest, now);
    last = now;
  }
  BOOST_TEST(largest > 0);
  // Each query moves 8 um of a depth near 1 mm.
  BOOST_TEST(step < 0.05 * largest);
}

BOOST_AUTO_TEST_CASE(the_query_uses_the_last_tool_pose_and_is_stamped_with_its_start) {
  Scene scene;
  scene.bodies = {ball("fixed", 0.05), ball("tool", 0.01, Motion::translation)};
  scene.bodies[1].X_WB.p = {0, 0, 0.0595};
  PrimitiveCollision node(test::default_params<PrimitiveCollision>(), test::context_for(scene));
  node.device.configure({});
  node.state.configure({});
  StepContext first(Time{5'000'000});
  node.step(first);
  BOOST_TEST(first.work() == 1);
  BOOST_TEST(node.contacts.pending_valid(0).ns == 5'000'000);
  BOOST_TEST(test::sent(node.contacts).bodies.X_WB[0].p.z == 0.0595);
  PhysicsState s;
  s.X_WT.p = {0, 1, 0};
  node.state.push({Time{5'000'000}, Time{6'000'000}, 0}, &s);
  node.contacts.clear_pending();
  StepContext second(Time{7'000'000});
  node.step(second);
  BOOST_TEST(second.work() == 0);
  BOOST_TEST(test::sent(node.contacts).count == 0);
}

namespace {
auto says(const std::string& text) {
  return [text](const InputError& e) {
    BOOST_TEST_INFO(e.what());
    return std::string(e.what()).find(text) != std::string::npos;
  };
}
}  // namespace

BOOST_AUTO_TEST_CASE(the_wrong_shape_of_tool_names_the_right_node) {
  Scene scene;
  scene.bodies = {ball("fixed", 0.01), mesh_body("tool", test::box({0.1, 0.1, 0.1}), Motion::rigid)};
  BOOST_CHECK_EXCEPTION(PrimitiveCollision(test::default_params<PrimitiveCollision>(), test::context_for(scene)),
                        InputError,
                        says("the moving body 'tool' is a mesh; expected a sphere, a capsule or a box, or use "
                             "collision.sdf"));
}

BOOST_AUTO_TEST_CASE(a_mesh_that_is_no_solid_names_its_body_and_file) {
  TriangleMesh open = test::box({0.1, 0.1, 0.1});
  open.faces.pop_back();
  Scene scene;
  scene.bodies = {mesh_body("leaky", open), ball("tool", 0.01, Motion::rigid)};
  BOOST_CHECK_EXCEPTION(PrimitiveCollision(test::default_params<PrimitiveCollision>(), test::context_for(scene)),
                        InputError, says("body 'leaky': "));
  BOOST_CHECK_EXCEPTION(ExactCollision(test::default_params<ExactCollision>(), test::context_for(scene)), InputError,
                        says("collision_leaky.off: "));
}

BOOST_AUTO_TEST_CASE(large_triangles_touch_between_their_vertices_without_a_spacing) {
  // Both have vertices at their corners only.
  Scene scene;
  scene.bodies = {mesh_body("table", test::box({0.1, 0.1, 0.02})),
                  mesh_body("block", test::box({0.04, 0.04, 0.04}), Motion::rigid)};
  for (Body& b : scene.bodies) b.material = {.stiffness = 4000, .damping = 2, .friction = 0.3, .patch_area = 1e-4};
  auto params = coarse_params();
  params.margin = 0.0002;
  SdfCollision node(params, test::context_for(scene));
  ContactSet set;
  node.query({{0.003, 0.001, 0.0295}, {}}, set);
  check_geometry(set);
  // Series of the two: 2000 N/m a patch, 16 patches; the few samples of the table below the block are not quite so
  // many.
  BOOST_TEST(total_stiffness(set) == 2000 * 16, tt::tolerance(0.03));
  double largest = 0;
  int inside = 0;
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    largest = std::max(largest, c.weight);
    inside += std::max(std::abs(c.p_TC.x), std::abs(c.p_TC.y)) < 0.0199 ? 1 : 0;
  }
  BOOST_TEST(inside > 16);
  // No sample stands for much more than the square of an eighth of the longest side, here of the table.
  BOOST_TEST(largest < 2 * 0.0125 * 0.0125 / 1e-4);
}

BOOST_AUTO_TEST_CASE(a_spacing_that_gives_too_many_samples_names_the_body) {
  Scene scene;
  scene.bodies = {test::shaped("floor", PlaneShape{}), test::shaped("tool", BoxShape{{1, 1, 1}}, Motion::rigid)};
  auto params = test::default_params<PrimitiveCollision>();
  params.spacing = 1e-4;
  BOOST_CHECK_EXCEPTION(PrimitiveCollision(params, test::context_for(scene)), InputError,
                        says("body 'tool': a spacing of 0.1"));
  Scene meshes;
  meshes.bodies = {test::shaped("floor", PlaneShape{}), mesh_body("tool", test::box({1, 1, 1}), Motion::rigid)};
  auto of_mesh = coarse_params();
  of_mesh.spacing = 1e-4;
  BOOST_CHECK_EXCEPTION(SdfCollision(of_mesh, test::context_for(meshes)), InputError,
                        says("body 'tool': a spacing of 0.1"));
}

BOOST_AUTO_TEST_CASE(a_mesh_that_meets_round_bodies_alone_has_no_samples) {
  // Samples this near would be far too many, and are asked for by none of the pairs but the last.
  Scene scene;
  scene.bodies = {mesh_body("block", test::box({1, 1, 1})), ball("tool", 0.01, Motion::rigid),
                  test::shaped("finger", CapsuleShape{0.01, 0.02}, Motion::rigid)};
  auto params = coarse_params();
  params.spacing = 1e-4;
  BOOST_CHECK_NO_THROW(SdfCollision(params, test::context_for(scene)));
  scene.bodies.push_back(mesh_body("fixed", test::box({1, 1, 1})));
  BOOST_CHECK_NO_THROW(SdfCollision(params, test::context_for(scene)));
  scene.bodies.back().motion = Motion::rigid;
  BOOST_CHECK_THROW(SdfCollision(params, test::context_for(scene)), InputError);
}

BOOST_AUTO_TEST_CASE(cells_that_would_take_hours_name_the_body) {
  Scene scene;
  scene.bodies = {mesh_body("bar", test::box({0.1, 0.02, 0.02})), ball("tool", 0.01, Motion::rigid)};
  auto params = test::default_params<SdfCollision>();
  params.resolution = 1024;
  params.band = 0.1;
  BOOST_CHECK_EXCEPTION(SdfCollision(params, test::context_for(scene)), InputError,
                        says("body 'bar': resolution 1024 with a band of 0.0125 m cuts the space about its mesh into "
                             "more than 34 million cells; lower the resolution or the band"));
  // Nor is there a band so wide that counting the cells fails.
  for (const double band : {100.0, 1e9, 1e300}) {
    BOOST_CHECK_EXCEPTION(build_cells(test::box({0.1, 0.02, 0.02}), {.resolution = 8, .band = band}), InputError,
                          says("lower the resolution or the band"));
  }
}

BOOST_AUTO_TEST_CASE(a_body_of_no_size_a_hand_could_feel_is_refused) {
  for (const double scale : {1e-300, 1e-9, 1e6, 1e200}) {
    Scene scene;
    scene.bodies = {mesh_body("bar", test::box({0.1, 0.02, 0.02})), ball("tool", 0.01, Motion::rigid)};
    std::get<MeshShape>(scene.bodies[0].shape).scale = scale;
    BOOST_CHECK_EXCEPTION(SdfCollision(coarse_params(), test::context_for(scene)), InputError,
                          says("a body must be 1 um to 1 km long"));
  }
}

BOOST_AUTO_TEST_CASE(a_scene_without_contact_needs_no_collision) {
  Scene scene;
  const NodeInfo info = SdfCollision::declare();
  BOOST_TEST(info.unneeded(scene) == "nothing in the scene moves");
  scene.bodies = {ball("tool", 0.01, Motion::rigid)};
  BOOST_TEST(info.unneeded(scene) == "the scene has nothing to hit");
  scene.bodies.push_back(ball("fixed", 0.01));
  BOOST_TEST(info.unneeded(scene).empty());
  scene.bodies[1].motion = Motion::rigid;
  BOOST_TEST(info.unneeded(scene).empty());
}

BOOST_AUTO_TEST_CASE(no_collision_sends_empty_sets_at_the_poses_it_was_told) {
  Scene scene;
  scene.bodies = {ball("fixed", 0.05), ball("tool", 0.02, Motion::rigid)};
  scene.bodies[1].X_WB.p = {0.03, 0, 0};
  NoCollision node(test::default_params<NoCollision>(), test::context_for(scene));
  node.device.configure({});
  StepContext step(Time{1});
  node.step(step);
  BOOST_TEST(test::sent(node.contacts).count == 0);
  BOOST_TEST(test::sent(node.contacts).bodies.count == 1);
  BOOST_TEST(test::sent(node.contacts).bodies.X_WB[0].p.x == 0.03);
}

BOOST_AUTO_TEST_CASE(the_collision_that_suits_a_scene_is_chosen_with_its_reason) {
  const auto chosen = [](const Scene& scene) {
    const Resolution r = AutoCollision::choose(scene);
    return r.info->type + ": " + r.reason;
  };
  Scene scene;
  scene.bodies = {ball("tool", 0.01, Motion::translation)};
  BOOST_TEST(chosen(scene) == "collision.none: the scene has nothing to hit");
  scene.bodies.push_back(mesh_body("rock", test::box({0.1, 0.1, 0.1})));
  BOOST_TEST(chosen(scene) == "collision.primitive: the moving body tool is a sphere");
  scene.bodies.push_back(test::shaped("rod", CapsuleShape{0.01, 0.1}, Motion::rigid));
  BOOST_TEST(chosen(scene) ==
             "collision.primitive: the moving body tool is a sphere, the moving body rod is a capsule");
  scene.bodies[1].motion = Motion::rigid;
  BOOST_TEST(chosen(scene) == "collision.sdf: the moving body rock is a mesh");
}

BOOST_AUTO_TEST_CASE(several_moving_bodies_need_to_be_told_of) {
  Scene scene;
  scene.bodies = {ball("one", 0.01, Motion::rigid), ball("two", 0.02, Motion::translation), ball("three", 0.02)};
  scene.tool_name = "two";
  scene.bodies[0].X_WB.p = {0.1, 0, 0};
  PrimitiveCollision node(test::default_params<PrimitiveCollision>(), test::context_for(scene));
  node.device.configure({});
  const NodeInfo info = PrimitiveCollision::declare();
  BOOST_TEST(info.input("bodies")->needed(scene) == "2 bodies move: two, one");
  Scene one = scene;
  one.bodies[0].motion = Motion::fixed;
  BOOST_TEST(info.input("bodies")->needed(one).empty());
  StepContext step(Time{1});
  node.bodies.configure({});
  // Before the first message they are where the scene puts them: two and three at one place.
  node.step(step);
  const ContactSet& start = test::sent(node.contacts);
  BOOST_REQUIRE(start.count == 1);
  BOOST_TEST(start.pair[0].body == 0);
  BOOST_TEST(start.pair[0].other == ContactPair::fixed);
  BOOST_TEST(start.bodies.count == 2);
  BOOST_TEST(start.bodies.X_WB[1].p.x == 0.1);

  BodyStates states;
  states.count = 2;
  states.X_WB[0].p = {0.2, 0, 0};
  states.X_WB[1].p = {0.2, 0.029, 0};
  node.bodies.push({Time{1}, Time{1}, 0}, &states);
  node.contacts.clear_pending();
  node.step(step);
  const ContactSet& met = test::sent(node.contacts);
  BOOST_REQUIRE(met.count == 1);
  BOOST_TEST(met.pair[0].body == 0);
  BOOST_TEST(met.pair[0].other == 1);
  BOOST_TEST(met.contact[0].distance == -0.001, tt::tolerance(1e-9));
  BOOST_TEST(norm(met.contact[0].n_W - Vec3{0, -1, 0}) < 1e-12);
  check_geometry(met);

  states.count = 3;
  node.bodies.push({Time{2}, Time{2}, 1}, &states);
  BOOST_CHECK_EXCEPTION(node.step(step), InputError, says("has 3 moving bodies; the scene has 2: two, one"));
}

BOOST_AUTO_TEST_SUITE_END()
