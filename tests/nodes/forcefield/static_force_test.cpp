// The static force against springs in series, in closed form.
#include <boost/test/unit_test.hpp>

#include "nodes/forcefield/static_force.hpp"
#include "nodes/forcefield/supported_scene.hpp"
#include "tests/nodes/forcefield/field_scenes.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(static_force_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double k_t = 400;       // N/m
constexpr double margin = 0.005;  // m

/// Both materials have 2000 N/m unless a test says otherwise.
constexpr double k = 1000;                      // N/m
constexpr double series = k_t * k / (k_t + k);  // N/m

/// A block along y with a groove of 90 degrees in its top, whose bottom is the y axis.
TriangleMesh grooved_block() {
  constexpr double a = 0.05;
  const double outline[5][2] = {{0, 0}, {-a, a}, {-a, -a}, {a, -a}, {a, a}};
  TriangleMesh mesh;
  for (const double y : {-a, a}) {
    for (const auto& p : outline) mesh.vertices.push_back({p[0], y, p[1]});
  }
  for (int i = 0; i < 5; ++i) {
    const int next = (i + 1) % 5;
    mesh.faces.push_back({i, i + 5, next + 5});
    mesh.faces.push_back({i, next + 5, next});
    if (i == 0 || next == 0) continue;
    mesh.faces.push_back({0, i, next});
    mesh.faces.push_back({5, next + 5, i + 5});
  }
  return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(on_a_wall_it_is_that_of_two_springs_in_series) {
  Scene scene = floor_and_ball();
  scene.bodies[0].X_WB = {{0.1, -0.2, 0.3}, from_rotation_vector({0.5, -0.8, 0.3})};
  scene.bodies[1].X_WB.R = from_rotation_vector({0, 1, 0});
  const Vec3 n = rotate(scene.bodies[0].X_WB.R, {0, 0, 1});
  StaticForce force(scene, k_t, margin, nullptr);
  Dice dice(1);
  int near = 0, touching = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = scene.bodies[0].X_WB.p + dice.in_cube(0.05);
    const double phi = dot(n, p - scene.bodies[0].X_WB.p) - 0.01;
    const StaticForce::Result found = force.at(p);
    BOOST_TEST(norm(found.force - series * std::max(0.0, -phi) * n) < 1e-9);
    BOOST_TEST(found.near == (phi < margin));
    BOOST_TEST(found.settled);
    near += found.near ? 1 : 0;
    touching += phi < 0 ? 1 : 0;
  }
  BOOST_TEST(touching > 100);
  BOOST_TEST(near > touching);
}

BOOST_AUTO_TEST_CASE(on_a_mesh_and_on_a_ball_too) {
  Scene scene = floor_and_ball();
  scene.bodies[0] = field_body("box", MeshShape{write_off(box({0.1, 0.1, 0.1}), "field_box")});
  scene.bodies[0].material.stiffness = 3000;
  scene.bodies[1].material.stiffness = 1500;  // 1000 N/m together
  StaticForce on_box(scene, k_t, margin, nullptr);
  // Above the middle of the top, 3 mm to 20 mm deep, where no side is nearer.
  for (const double depth : {0.003, 0.01, 0.02}) {
    const StaticForce::Result found = on_box.at({0.004, -0.01, 0.06 - depth});
    BOOST_TEST(norm(found.force - Vec3{0, 0, series * depth}) < 1e-9);
  }
  scene.bodies[0] = field_body("ball", SphereShape{0.03});
  scene.bodies[1].material.stiffness = scene.bodies[0].material.stiffness;
  StaticForce on_ball(scene, k_t, margin, nullptr);
  const Vec3 way = Vec3{1, 2, -2} / 3;
  BOOST_TEST(norm(on_ball.at(0.035 * way).force - series * 0.005 * way) < 1e-9);
  BOOST_TEST(norm(on_ball.at(0.041 * way).force) == 0.0);
}

BOOST_AUTO_TEST_CASE(between_two_walls_both_push) {
  Scene scene = floor_and_ball();
  scene.bodies.push_back(field_body("wall", PlaneShape{}));
  scene.bodies.back().X_WB.R = from_rotation_vector({0, M_PI / 2, 0});  // faces +x
  StaticForce force(scene, k_t, margin, nullptr);
  const StaticForce::Result found = force.at({0.007, 0.4, 0.002});
  BOOST_TEST(norm(found.force - Vec3{series * 0.003, 0, series * 0.008}) < 1e-9);
  BOOST_TEST(found.settled);
}

BOOST_AUTO_TEST_CASE(in_a_groove_whose_sides_are_met_one_at_a_time_the_ball_rests_on_both) {
  Scene scene = floor_and_ball();
  scene.bodies[0] = field_body("block", MeshShape{write_off(grooved_block(), "grooved_block")});
  StaticForce force(scene, k_t, margin, nullptr);
  const double touches = 0.01 * std::sqrt(2.0);  // m, the height of the ball's centre
  for (const double depth : {0.003, 0.008}) {
    // On the line where both depths are y / sqrt 2: k_t (depth - y) = k (y / sqrt 2) / sqrt 2.
    const double y = k_t * depth / (k_t + k / 2);
    for (const double aside : {0.0, 0.3, -0.6}) {
      // As long as k_t x stays below what one side gives aside, it changes how they share, and nothing else.
      const double x = aside * k * y / 2 / k_t;
      const StaticForce::Result found = force.at({x, 0.01, touches - depth});
      const Vec3 wanted{-k_t * x, 0, k_t * (depth - y)};
      BOOST_TEST(norm(found.force - wanted) < 0.02 * norm(wanted), norm(found.force - wanted) / norm(wanted));
      BOOST_TEST(!found.settled);
    }
  }
}

BOOST_AUTO_TEST_CASE(friction_and_damping_change_nothing) {
  Scene scene = floor_and_ball(), smooth = scene;
  for (Body& body : smooth.bodies) body.material.friction = body.material.damping = 0;
  StaticForce force(scene, k_t, margin, nullptr), without(smooth, k_t, margin, nullptr);
  BOOST_TEST(norm(force.at({0.1, 0, 0.004}).force - without.at({0.1, 0, 0.004}).force) == 0.0);
}

BOOST_AUTO_TEST_CASE(scenes_that_have_no_field_are_refused_with_what_to_do) {
  const auto refusal = [](const Scene& scene) {
    return input_error([&] { check_static_scene("forcefield.x", scene); });
  };
  const auto says = [](const std::string& text, const std::string& part) {
    BOOST_TEST(text.find(part) != std::string::npos, text);
    BOOST_TEST(text.find("forcefield.x: ") == 0U, text);
    BOOST_TEST(text.find("use a prediction.* and an interpolation.* in its place") != std::string::npos, text);
  };
  Scene scene = floor_and_ball();
  BOOST_TEST(refusal(scene).empty());
  Scene two = scene;
  two.bodies.push_back(field_body("block", BoxShape{{0.1, 0.1, 0.1}}, Motion::translation));
  says(refusal(two), "body 'block' moves besides the tool");
  Scene turning = scene;
  turning.bodies[1].motion = Motion::rigid;
  says(refusal(turning), "the tool 'tool' rotates");
  Scene alone = scene;
  alone.bodies.erase(alone.bodies.begin());
  says(refusal(alone), "nothing to hit");
  Scene still = scene;
  still.bodies[1].motion = Motion::fixed;
  says(refusal(still), "nothing in the scene moves");
}

BOOST_AUTO_TEST_SUITE_END()
