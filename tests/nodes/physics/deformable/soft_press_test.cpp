// Steps of deformable bodies with rigid ones that touch them: balance, friction, deep and fast starts, supports.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>

#include "tests/nodes/physics/deformable/soft_rig.hpp"

BOOST_AUTO_TEST_SUITE(soft_press_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double g = 9.81, radius = 0.008;  // m/s^2, m

/// A block of gel whose top is at z = 0, held at its bottom, and a ball.
Scene ball_on_gel(const Vec3& p, double mass, const Vec3& gravity, double young, double friction = 0) {
  Scene scene;
  scene.gravity_W = gravity;
  scene.bodies = {gel_box("gel", {0.06, 0.06, 0.03}, {0, 0, -0.015}, young, 0.015), ball_tool(radius, p, mass)};
  hold_bottom(scene.bodies[0]);
  for (Body& body : scene.bodies) body.material.friction = friction;
  return scene;
}

Eigen::Vector3d sum(const Eigen::VectorXd& by_unknown) {
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (Eigen::Index u = 0; u < by_unknown.size(); u += 3) total += by_unknown.segment<3>(u);
  return total;
}

/// N, the sum of the contact forces on the free nodes, by Newton's second law over a step of implicit Euler without
/// damping.
Eigen::Vector3d contact_on_nodes(const SoftRig& rig, const Eigen::VectorXd& v_before, double h) {
  Eigen::VectorXd elastic;
  rig.model().force(rig.step->x(), elastic);
  return (rig.momentum() - rig.momentum(v_before)) / h - sum(elastic) - sum(rig.model().weight(rig.scene.gravity_W));
}

bool all_finite(const SoftRig& rig) {
  return rig.step->x().allFinite() && rig.step->v().allFinite() && is_finite(rig.bodies.X_WB[0].p) &&
         is_finite(rig.bodies.V_WB[0].v);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_ball_comes_to_rest_on_gel_with_its_weight_carried_through_to_the_support) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    Scene scene = ball_on_gel({0.002, 0.001, radius + 0.001}, 0.05, {0, 0, -g}, 2e4, 0.3);
    scene.bodies[0].deformable.damping = 0.02;
    for (Body& body : scene.bodies) body.material.damping = 20;
    SoftRig rig(scene, {.integrator = integrator, .tolerance = 1e-8});
    StepResult result;
    for (int i = 0; i < 400; ++i) result = rig.advance(0.01);
    BOOST_TEST_MESSAGE("force " << result.contact_T_W.force.z << " for " << 0.05 * g << ", speed "
                                << norm(rig.bodies.V_WB[0].v) << ", damped " << rig.step->counts().damped);
    BOOST_TEST(result.contact_T_W.force.z == 0.05 * g, tt::tolerance(1e-3));
    BOOST_TEST(std::abs(result.contact_T_W.force.x) < 1e-3 * 0.05 * g);
    BOOST_TEST(norm(rig.bodies.V_WB[0].v) < 1e-4);
    BOOST_TEST(result.touching > 0);
    // What the elements pull the free nodes up with, the support pushes.
    Eigen::VectorXd elastic;
    rig.model().force(rig.step->x(), elastic);
    const double carried = 0.05 * g - sum(rig.model().weight(scene.gravity_W)).z();
    BOOST_TEST(sum(elastic).z() == carried, tt::tolerance(1e-3));
    BOOST_TEST(rig.bodies.X_WB[0].p.z < radius);
  }
}

BOOST_AUTO_TEST_CASE(what_the_ball_gets_the_nodes_lose_in_every_step) {
  // Pressed and dragged by the handle, with friction.
  SoftRig rig(ball_on_gel({0, 0, radius + 0.0005}, 0.05, {}, 2e4, 0.4));
  rig.coupling = {.k_t = 400, .b_t = 8, .force_max = 8, .torque_max = 1};
  double most = 0, worst = 0;
  for (int i = 0; i < 60; ++i) {
    const double h = 0.005, t = h * i;
    const Eigen::VectorXd v = rig.step->v();
    DeviceState handle;
    handle.X_WD.p = {0.05 * t, 0.02 * std::sin(8 * t), radius + 0.0005 - 0.03 * t};
    handle.V_WD.v = {0.05, 0.16 * std::cos(8 * t), -0.03};
    const StepResult result = rig.advance(h, handle);
    const Eigen::Vector3d on_nodes = contact_on_nodes(rig, v, h), on_tool = eigen(result.contact_T_W.force);
    most = std::max(most, on_tool.norm());
    worst = std::max(worst, (on_nodes + on_tool).norm());
    BOOST_TEST((result.outcome == StepOutcome::converged));
  }
  BOOST_TEST_MESSAGE("third law off by " << worst << " of " << most << " N");
  BOOST_TEST(most > 0.5);
  BOOST_TEST(worst < 1e-6 * most);
}

BOOST_AUTO_TEST_CASE(a_ball_and_a_free_body_keep_their_momentum_through_contact) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    Scene scene = ball_on_gel({0.003, 0.002, radius + 0.001}, 0.05, {}, 2e4, 0.4);
    scene.bodies[0].deformable.fixed.clear();
    SoftRig rig(scene, {.integrator = integrator});
    rig.bodies.V_WB[0].v = {0.2, 0, -0.4};
    const Eigen::Vector3d before = 0.05 * eigen(rig.bodies.V_WB[0].v);
    double worst = 0;
    int touching = 0;
    for (int i = 0; i < 60; ++i) {
      touching += rig.advance(0.002).touching > 0 ? 1 : 0;
      worst = std::max(worst, (rig.momentum() + 0.05 * eigen(rig.bodies.V_WB[0].v) - before).norm());
    }
    BOOST_TEST_MESSAGE("momentum off by " << worst / before.norm() << ", " << touching << " steps in contact, damped "
                                          << rig.step->counts().damped);
    BOOST_TEST(touching > 3);
    BOOST_TEST(rig.step->counts().damped == 0);
    BOOST_TEST(worst < 1e-6 * before.norm());
  }
}

BOOST_AUTO_TEST_CASE(a_ball_sticks_below_the_cone_of_friction_and_slides_above) {
  // Pulled sideways by a slanted weight. The ball lies 0.3 mm deep, so that its contacts' normals are nearly one.
  constexpr double mu = 0.3, mass = 0.1;
  for (const double slant : {0.2, 0.27, 0.36, 0.5}) {
    Scene scene = ball_on_gel({-0.01, 0, radius - 0.0003}, mass, {slant * g, 0, -g}, 2e6, mu);
    for (Body& body : scene.bodies)
      body.material = {.stiffness = 86000, .damping = 5, .friction = mu, .patch_area = 1e-4};
    scene.bodies[0].deformable.damping = 0.01;
    scene.bodies[0].deformable.density = 1;  // so that it does not lean itself
    SoftRig rig(scene, {.tolerance = 1e-8, .stick_velocity = 1e-5, .margin = 5e-4, .spacing = 6e-4});
    StepResult result;
    for (int i = 0; i < 30; ++i) result = rig.advance(0.005);
    const Wrench& wrench = result.contact_T_W;
    const double N = wrench.force.z, T = -wrench.force.x, speed = rig.bodies.V_WB[0].v.x;
    BOOST_TEST_MESSAGE("slant " << slant << ": " << T / N << ", speed " << speed);
    BOOST_TEST(N == mass * g, tt::tolerance(0.05));
    if (slant < mu) {
      BOOST_TEST(T / N == slant, tt::tolerance(0.02));
      BOOST_TEST(std::abs(speed) < 3e-5);
    } else {
      BOOST_TEST(T / N == mu, tt::tolerance(0.08));
      BOOST_TEST(speed == 0.15 * (slant - mu) * g, tt::tolerance(0.1));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_ball_that_begins_deep_in_the_gel_comes_out) {
  for (const double depth : {0.5 * radius, radius, 2 * radius, 0.02}) {
    for (const Elasticity law : {Elasticity::corotational, Elasticity::neo_hookean}) {
      Scene scene = ball_on_gel({0.001, 0.0007, radius - depth}, 0.05, {}, 2e4);
      scene.bodies[0].deformable.damping = 0.005;
      SoftRig rig(scene, {.law = law, .tolerance = 1e-5});
      bool finite = true;
      for (int i = 0; i < 150; ++i) {
        rig.advance(0.01);
        finite = finite && all_finite(rig);
      }
      BOOST_TEST_CONTEXT("depth " << depth) {
        BOOST_TEST_MESSAGE("depth " << depth << ": height " << rig.bodies.X_WB[0].p.z << ", damped "
                                    << rig.step->counts().damped << ", left out " << rig.step->counts().left_out);
        BOOST_TEST(finite);
        BOOST_TEST(rig.bodies.X_WB[0].p.z > 0.9 * radius);
        BOOST_TEST(rig.model().smallest_volume_ratio(rig.step->x()) > 0);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_fast_ball_is_not_through_after_a_step) {
  for (const double h : {0.005, 0.0167, 0.02}) {
    for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
      Scene scene = ball_on_gel({0.001, 0.0007, radius + 0.005}, 0.05, {}, 2e4);
      scene.bodies[0].deformable.damping = 0.005;
      SoftRig rig(scene, {.integrator = integrator, .iterations = 8, .tolerance = 1e-3});
      rig.bodies.V_WB[0].v = {0, 0, -2};
      double lowest = 1;
      bool finite = true;
      for (int i = 0; i < 40; ++i) {
        rig.advance(h);
        lowest = std::min(lowest, rig.bodies.X_WB[0].p.z);
        finite = finite && all_finite(rig);
      }
      BOOST_TEST_CONTEXT("h " << h << ", midpoint " << (integrator == Integrator::midpoint)) {
        BOOST_TEST_MESSAGE("h " << h << ", midpoint " << (integrator == Integrator::midpoint) << ": lowest " << lowest
                                << ", at last " << rig.bodies.X_WB[0].p.z << ", speed " << rig.bodies.V_WB[0].v.z
                                << ", damped " << rig.step->counts().damped);
        BOOST_TEST(finite);
        BOOST_TEST(lowest > -0.03);
        BOOST_TEST(rig.bodies.X_WB[0].p.z > 0);
        BOOST_TEST(std::abs(rig.bodies.V_WB[0].v.z) <= 2);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(reused_factors_change_no_more_than_the_tolerance) {
  for (const double damping : {0.0, 0.005}) {
    std::array<Eigen::VectorXd, 2> x;
    std::array<std::int64_t, 2> factors{};
    for (const bool reuse : {false, true}) {
      Scene scene = ball_on_gel({0.001, 0.0007, radius + 0.001}, 0.05, {0, 0, -g}, 2e4, 0.3);
      scene.bodies[0].deformable.damping = damping;
      SoftRig rig(scene, {.reuse = reuse});
      rig.bodies.V_WB[0].v = {0.1, 0, -0.1};
      for (int i = 0; i < 20; ++i) rig.advance(0.01);
      x[reuse ? 1 : 0] = rig.step->x() - rig.model().rest();
      factors[reuse ? 1 : 0] = rig.step->counts().factors;
    }
    const double off = (x[1] - x[0]).norm() / x[0].norm();
    BOOST_TEST_MESSAGE("damping " << damping << ": reuse changes displacements by " << off << ", " << factors[1]
                                  << " factors for " << factors[0]);
    BOOST_TEST(factors[1] < factors[0]);
    BOOST_TEST(off < 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(a_soft_box_rests_on_a_fixed_plane_beside_a_held_one) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const double edge : {0.02, 0.008}) {
      Scene scene;
      scene.gravity_W = {0, 0, -g};
      Body ground;
      ground.name = "ground";
      ground.shape = PlaneShape{};
      ground.material = {.stiffness = 20000, .damping = 20, .friction = 0.3, .patch_area = 1e-4};
      scene.bodies = {gel_box("resting", {0.04, 0.04, 0.04}, {0, 0, 0.02}, 5e4, edge),
                      gel_box("held", {0.04, 0.04, 0.02}, {0.1, 0, 0.05}, 2e4, 0.02), ground, far_tool()};
      hold_bottom(scene.bodies[1]);
      for (std::size_t b : {0U, 1U}) {
        scene.bodies[b].deformable.damping = 0.01;
        scene.bodies[b].material.damping = 20;
        scene.bodies[b].material.friction = 0.3;
      }
      SoftRig rig(scene, {.integrator = integrator, .tolerance = 1e-8});
      for (int i = 0; i < 250; ++i) rig.advance(0.01);
      // The elements of the resting body push nothing outside, so at rest contact carries its weight.
      Eigen::VectorXd left, weight = rig.model().weight(scene.gravity_W);
      rig.model().force(rig.step->x(), left);
      left += weight;
      double carried = 0, total = 0, speed = 0;
      for (int u = 0; u < rig.model().unknowns(); u += 3) {
        if (rig.model().body_of(u) != 0) continue;
        carried -= left[u + 2];
        total -= weight[u + 2];
        speed = std::max(speed, rig.step->v().segment<3>(u).norm());
      }
      BOOST_TEST_MESSAGE("edge " << edge << ": carried " << carried << " of " << total << " N, speed " << speed
                                 << ", damped " << rig.step->counts().damped << ", left out "
                                 << rig.step->counts().left_out);
      BOOST_TEST(total == 0.04 * 0.04 * 0.04 * 1000 * g, tt::tolerance(1e-9));
      BOOST_TEST(carried == total, tt::tolerance(1e-3));
      // By the midpoint rule what is faster than the step goes to and fro, undamped but small.
      BOOST_TEST(speed < (integrator == Integrator::midpoint ? 0.05 : 1e-4));
      // It has not wandered: the middle of the bottom stays where it was put, but for the depth of the contact.
      for (int node = 0; node < rig.model().nodes(); ++node) {
        const Vec3 rest = SoftRig::at(rig.model().rest(), node), now = SoftRig::at(rig.step->x(), node);
        if (norm(rest) < 1e-9) BOOST_TEST(norm(now - rest) < 1e-3);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_ball_presses_on_faces_that_do_not_move_also_after_it_was_near_others) {
  // All but the bottom is held, so that faces around the ball have no free node.
  Scene scene = ball_on_gel({0, 0, -0.03 - radius - 0.001}, 0.05, {}, 2e4);
  scene.bodies[0].deformable.fixed = {BoxRegion{{-1, -1, -0.01}, {1, 1, 1}}};
  SoftRig rig(scene, {.patch_reach = 0.005});
  rig.advance(0.01);
  BOOST_TEST(!rig.step->patch().nodes().empty());
  rig.bodies.X_WB[0].p = {0.002, 0.001, radius + 0.001};
  rig.bodies.V_WB[0].v = {0, 0, -0.2};
  double most = 0;
  for (int i = 0; i < 10; ++i) {
    const StepResult result = rig.advance(0.005);
    BOOST_TEST((result.outcome == StepOutcome::converged));
    most = std::max(most, result.contact_T_W.force.z);
    BOOST_REQUIRE(all_finite(rig));
  }
  BOOST_TEST(most > 0.1);
  BOOST_TEST(rig.bodies.V_WB[0].v.z > 0);
}

BOOST_AUTO_TEST_SUITE_END()
