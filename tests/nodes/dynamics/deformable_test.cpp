// dynamics.deformable: what it refuses, and what it sends with a result.
#include <boost/test/unit_test.hpp>

#include <cmath>

#include "framework/core/check.hpp"
#include "nodes/dynamics/deformable.hpp"
#include "tests/nodes/dynamics/node_rig.hpp"

BOOST_AUTO_TEST_SUITE(deformable_test)

using namespace tactor;
using namespace tactor::test;

namespace {

using Rig = NodeRig<DeformableDynamics>;

/// A ball above a block of gel whose top is at z = 0.
Scene ball_over_gel(double gap) {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies.resize(1);
  Body& gel = scene.bodies[0];
  gel.name = "gel";
  gel.shape = BoxShape{{0.06, 0.06, 0.03}};
  gel.X_WB.p = {0, 0, -0.015};
  gel.motion = Motion::deformable;
  gel.deformable.cell_size = 0.015;
  gel.deformable.fixed = {HalfSpaceRegion{{0, 0, -0.015}, {0, 0, 1}}};
  scene.bodies.push_back(ball("tool", Motion::translation));
  scene.bodies[1].X_WB.p = {0.001, 0.002, 0.01 + gap};
  return scene;
}

DeformableDynamics::Params params(Integrator integrator = Integrator::implicit_euler) {
  auto p = default_params<DeformableDynamics>();
  p.integrator = integrator;
  p.start_at_device = false;
  return p;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_scene_where_nothing_deforms_or_nothing_moves_is_refused) {
  BOOST_CHECK_THROW(Rig(params(), ball_scene(Motion::translation)), InputError);
  Scene still = ball_over_gel(0.01);
  still.bodies[1].motion = Motion::fixed;
  BOOST_CHECK_THROW(Rig(params(), still), InputError);
}

BOOST_AUTO_TEST_CASE(a_coupling_of_a_massless_tool_is_refused) {
  Rig rig(params(), ball_over_gel(0.01));
  rig.coupling.massless = 1;
  rig.push_law();
  rig.device(0, {0, 0, 0.02});
  BOOST_CHECK_THROW(rig.step(0), RunError);
}

BOOST_AUTO_TEST_CASE(a_result_has_its_patch_and_the_surface_at_the_same_time_and_place) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    Rig rig(params(integrator), ball_over_gel(0.001));
    double deepest = 0;
    for (int k = 0; k < 20; ++k) {
      const int ms = 17 * k;
      rig.device(ms, {0.001, 0.002, 0.011 - 0.0003 * k});
      rig.node.patch.clear_pending();
      rig.node.surfaces.clear_pending();
      BOOST_REQUIRE(rig.step(ms) == 1U);
      BOOST_TEST(rig.valid_ms() == ms);
      BOOST_REQUIRE(rig.node.patch.pending() == 1U);
      BOOST_TEST(rig.node.patch.pending_valid(0).ns == ms * 1'000'000LL);
      const LocalPatch& patch = sent(rig.node.patch);
      if (k == 0) continue;  // nothing has been stepped yet
      BOOST_TEST(is_usable(patch));
      BOOST_TEST(!patch.nodes.empty());
      BOOST_TEST(!patch.faces.empty());
      // The lowest node of the top is near the ball's lowest point.
      double lowest = 1;
      for (const PatchNode& node : patch.nodes) {
        if (node.p_W.z > -0.01) lowest = std::min(lowest, node.p_W.z);
      }
      deepest = std::min(deepest, lowest);
      const DeformedSurfaces& surfaces = sent(rig.node.surfaces);
      double shown = 1;
      for (const ShownPoint& p : surfaces.nodes) {
        if (p.p_W[2] > -0.01F) shown = std::min(shown, static_cast<double>(p.p_W[2]));
      }
      BOOST_TEST(std::abs(shown - lowest) < 1e-3);
    }
    BOOST_TEST(deepest < -1e-4);
    BOOST_TEST(rig.state().contact_T_W.force.z > 0.01);
    BOOST_TEST(rig.metrics().at("deformable.unsent_patches") == 0.0);
    BOOST_TEST(rig.metrics().count("deformable.euler_steps") == (integrator == Integrator::midpoint ? 1U : 0U));
  }
}

BOOST_AUTO_TEST_CASE(far_from_what_deforms_the_patch_is_empty) {
  Rig rig(params(), ball_over_gel(0.5));
  for (int k = 0; k < 3; ++k) {
    rig.device(17 * k, {0, 0, 0.51});
    rig.node.patch.clear_pending();
    BOOST_REQUIRE(rig.step(17 * k) == 1U);
    BOOST_TEST(sent(rig.node.patch).nodes.empty());
  }
}

BOOST_AUTO_TEST_SUITE_END()
