// The contacts of the collision nodes: geometry, weights, materials, capacity, refusals.
#include <boost/test/unit_test.hpp>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>

#include "nodes/collision/mesh.hpp"
#include "nodes/collision/sphere.hpp"
#include "tests/nodes/defaults.hpp"
#include "tests/nodes/shapes.hpp"

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

Body mesh_body(const std::string& name, const TriangleMesh& mesh, Motion motion = Motion::fixed) {
  Body body;
  body.name = name;
  body.shape = MeshShape{test::write_off(mesh, "collision_" + name)};
  body.motion = motion;
  return body;
}

Body ball(const std::string& name, double radius, Motion motion = Motion::fixed) {
  Body body;
  body.name = name;
  body.shape = SphereShape{radius};
  body.motion = motion;
  return body;
}

/// A check that holds for every contact: its distance is that between its two points along its normal.
void check_geometry(const ContactSet& set) {
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    BOOST_TEST(norm(c.n_W) == 1.0, tt::tolerance(1e-12));
    const Vec3 gap = transform(set.bodies.X_WB[0], c.p_TC) - c.p_WC;
    BOOST_TEST(norm(gap - c.distance * c.n_W) < 1e-11);
  }
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
  SphereCollision node(test::default_params<SphereCollision>(), test::context_for(scene));
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
  SphereCollision node(test::default_params<SphereCollision>(), test::context_for(scene));
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
  const auto params = test::default_params<SphereCollision>();
  SphereCollision node(params, test::context_for(scene)), fresh(params, test::context_for(scene));
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
  MeshCollision::Params p = test::default_params<MeshCollision>();
  p.margin = 0.0002;
  for (const double spacing : {0.012, 0.006}) {
    p.spacing = spacing;
    MeshCollision node(p, test::context_for(scene));
    ContactSet set;
    node.query({{0.003, 0.001, 0.0295}, {}}, set);
    check_geometry(set);
    BOOST_TEST((set.truncated > 0) == (spacing < 0.01));
    // Series of the two: 2000 N/m a patch, 16 patches. Samples on the rim share their area with the sides.
    BOOST_TEST(total_stiffness(set) == 2000 * 16, tt::tolerance(0.25));
    // Samples nearer to the side than to the bottom push aside; the others push up.
    int up = 0;
    for (int i = 0; i < set.count; ++i) up += set.contact[static_cast<std::size_t>(i)].n_W.z > 1 - 1e-9 ? 1 : 0;
    BOOST_TEST(up > 0.9 * set.count);
  }
}

BOOST_AUTO_TEST_CASE(contact_is_found_from_either_side) {
  // The tool's only vertices are far from where the spike of the fixed body enters its face.
  TriangleMesh spike = test::box({0.02, 0.02, 0.02});
  for (const std::size_t i : {4U, 5U, 6U, 7U})
    spike.vertices[i] = {1e-4 * spike.vertices[i].x, 1e-4 * spike.vertices[i].y, 0.03};
  Scene scene;
  scene.bodies = {mesh_body("spike", spike), mesh_body("slab", test::box({0.2, 0.2, 0.02}), Motion::rigid)};
  MeshCollision node(test::default_params<MeshCollision>(), test::context_for(scene));
  ContactSet set;
  node.query({{0.03, -0.02, 0.0395}, {}}, set);
  BOOST_TEST(set.penetrating == 4);
  check_geometry(set);
  for (int i = 0; i < set.count; ++i) {
    const Contact& c = set.contact[static_cast<std::size_t>(i)];
    BOOST_TEST(c.distance == -0.0005, tt::tolerance(1e-6));
    BOOST_TEST(norm(c.n_W - Vec3{0, 0, 1}) < 1e-9);
    BOOST_TEST(norm(transform(set.bodies.X_WB[0], c.p_TC) - Vec3{c.p_WC.x, c.p_WC.y, 0.0295}) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(a_full_set_keeps_the_deepest) {
  Scene scene;
  scene.bodies = {mesh_body("rock", test::icosphere(0.05, 4)),
                  mesh_body("slab", test::box({0.2, 0.2, 0.04}), Motion::rigid)};
  MeshCollision node(test::default_params<MeshCollision>(), test::context_for(scene));
  ContactSet set;
  node.query({{0, 0, 0.06}, {}}, set);
  BOOST_REQUIRE(set.count == ContactSet::capacity);
  BOOST_TEST(set.truncated > 50);
  // The vertices of the rock higher than the shallowest one kept are all in the set.
  double shallowest = -1;
  for (const Contact& c : set.contact) shallowest = std::max(shallowest, c.distance);
  int deeper = 0;
  const TriangleMesh rock = test::icosphere(0.05, 4);
  for (const Vec3& v : rock.vertices) deeper += 0.04 - v.z < shallowest - 1e-12 ? 1 : 0;
  BOOST_TEST(deeper < ContactSet::capacity);
  BOOST_TEST(deeper > ContactSet::capacity - 30);
}

BOOST_AUTO_TEST_CASE(contact_forces_change_smoothly_as_samples_come_and_go) {
  Scene scene;
  scene.bodies = {mesh_body("rock", test::icosphere(0.05, 4)),
                  mesh_body("tool", test::icosphere(0.03, 3), Motion::rigid)};
  MeshCollision node(test::default_params<MeshCollision>(), test::context_for(scene));
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
  SphereCollision node(test::default_params<SphereCollision>(), test::context_for(scene));
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

BOOST_AUTO_TEST_CASE(the_wrong_shape_of_tool_names_the_right_node) {
  Scene scene;
  scene.bodies = {mesh_body("block", test::box({0.1, 0.1, 0.1})), ball("tool", 0.01, Motion::rigid)};
  const auto says = [](const char* text) {
    return [text](const InputError& e) { return std::string(e.what()).find(text) != std::string::npos; };
  };
  BOOST_CHECK_EXCEPTION(MeshCollision(test::default_params<MeshCollision>(), test::context_for(scene)), InputError,
                        says("use collision.sphere"));
  scene.bodies[1] = mesh_body("tool", test::box({0.1, 0.1, 0.1}), Motion::rigid);
  BOOST_CHECK_EXCEPTION(SphereCollision(test::default_params<SphereCollision>(), test::context_for(scene)), InputError,
                        says("use collision.mesh"));
}

BOOST_AUTO_TEST_CASE(a_scene_without_contact_needs_no_collision) {
  Scene scene;
  const NodeInfo info = MeshCollision::declare();
  BOOST_TEST(info.unneeded(scene) == "nothing in the scene moves");
  scene.bodies = {ball("tool", 0.01, Motion::rigid)};
  BOOST_TEST(info.unneeded(scene) == "the scene has nothing to hit");
  scene.bodies.push_back(ball("fixed", 0.01));
  BOOST_TEST(info.unneeded(scene).empty());
}
