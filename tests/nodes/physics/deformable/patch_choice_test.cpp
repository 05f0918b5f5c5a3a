// Which nodes a patch has, and which stand far from it.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>

#include "nodes/physics/deformable/patch_choice.hpp"
#include "nodes/physics/deformable/spread_nodes.hpp"
#include "tests/nodes/physics/deformable/soft_rig.hpp"

BOOST_AUTO_TEST_SUITE(patch_choice_test)

using namespace tactor;
using namespace tactor::test;

namespace {

Scene over_gel(Body tool) {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies = {gel_box("gel", {0.1, 0.1, 0.03}, {0, 0, -0.015}, 2e4, 0.008), std::move(tool)};
  hold_bottom(scene.bodies[0]);
  return scene;
}
Body plate(double side, double gap) {
  Body tool = ball_tool(0.01, {0, 0, 0.005 + gap}, 0.05);
  tool.shape = BoxShape{{side, side, 0.01}};
  return tool;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_patch_has_twice_as_many_nodes_as_are_touched) {
  for (const double side : {0.02, 0.03, 0.04, 0.08}) {
    for (const double gap : {-0.001, 0.001, 0.0025, 0.01}) {
      SoftRig rig(over_gel(plate(side, gap)), {.patch_nodes = 36});
      rig.step->refresh(rig.bodies);
      // Closer than a twentieth of the reach: over the plate, whose distance below it is the gap. A node is as close as
      // the middles of its faces.
      const double near = 0.05 * 0.04;
      std::vector<char> is_near(static_cast<std::size_t>(rig.model().nodes()), 0);
      const auto distance = [&](const Vec3& p) {
        if (p.z < -0.01) return 1.0;
        const double x = std::max(std::abs(p.x) - side / 2, 0.0), y = std::max(std::abs(p.y) - side / 2, 0.0);
        return gap > 0              ? std::sqrt(x * x + y * y + (p.z - gap) * (p.z - gap))
               : std::max(x, y) > 0 ? std::hypot(x, y)
                                    : gap;
      };
      for (const auto& face : rig.soft.surface.faces) {
        Vec3 middle;
        for (const int node : face) {
          const Vec3 p = SoftRig::at(rig.step->x(), node);
          middle += (1.0 / 3) * p;
          if (distance(p) < near) is_near[static_cast<std::size_t>(node)] = 1;
        }
        if (distance(middle) < near) {
          for (const int node : face) is_near[static_cast<std::size_t>(node)] = 1;
        }
      }
      const auto touched = static_cast<std::size_t>(std::count(is_near.begin(), is_near.end(), 1));
      const std::size_t wanted = std::clamp<std::size_t>(2 * touched, 16, 36);
      BOOST_TEST_CONTEXT("plate of " << side << " at " << gap << ", touched " << touched) {
        BOOST_TEST(rig.step->patch().around_tool() == wanted);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_patch_that_others_fill_is_kept_while_they_touch_the_same) {
  Scene scene = over_gel(far_tool());
  scene.bodies[0] = gel_box("gel", {0.1, 0.1, 0.03}, {0, 0, -0.015}, 2e4, 0.004);
  SoftRig rig(scene);
  const ContactBody tool(*scene.tool(), 0, false, 0.04, cell_distances({}, nullptr), nullptr);
  PatchChoice patch(rig.soft, tool, RigOptions{}.deformable());
  constexpr std::size_t most = RigidStep::most_patch_nodes;
  std::vector<SoftContact> contacts;
  for (const auto& face : rig.soft.surface.faces) {
    SoftContact contact;
    contact.node = face;
    contact.share = {1, 0, 0};
    contacts.push_back(contact);
  }
  const auto update = [&](std::size_t count) {
    return patch.update(rig.step->x(), rig.bodies.X_WB[0], {}, std::span(contacts).first(count));
  };
  BOOST_TEST(update(4));
  BOOST_TEST(patch.nodes().size() < most);
  BOOST_TEST(!update(4));
  BOOST_TEST(update(contacts.size()));
  BOOST_TEST(patch.nodes().size() == most);
  BOOST_TEST(!update(contacts.size()));
}

BOOST_AUTO_TEST_CASE(spread_nodes_are_free_and_each_the_farthest_from_those_before) {
  SoftRig rig(over_gel(far_tool()));
  const ElasticModel& model = rig.model();
  const std::vector<int> spread = spread_nodes(rig.soft, 12).front();
  BOOST_REQUIRE(spread.size() == 12U);
  std::vector<int> before;
  for (const int node : rig.soft.surface_nodes) {
    if (model.unknown_of(node) < 0) before.push_back(node);
  }
  const auto apart = [&](int node) {
    double least = 1;
    for (const int other : before) {
      least = std::min(least, norm(SoftRig::at(model.rest(), node) - SoftRig::at(model.rest(), other)));
    }
    return least;
  };
  for (const int node : spread) {
    BOOST_TEST(model.unknown_of(node) >= 0);
    for (const int other : rig.soft.surface_nodes) BOOST_TEST(apart(other) <= apart(node) + 1e-12);
    before.push_back(node);
  }
}

BOOST_AUTO_TEST_CASE(a_body_that_nothing_holds_and_a_small_one_have_spread_nodes_too) {
  Scene scene;
  scene.bodies = {gel_box("free", {0.03, 0.03, 0.03}, {}, 2e4, 0.015),
                  gel_box("other", {0.01, 0.01, 0.01}, {0.1, 0, 0}, 2e4, 0.02), far_tool()};
  SoftRig rig(scene);
  const auto spread = spread_nodes(rig.soft, 100);
  BOOST_REQUIRE(spread.size() == 2U);
  for (std::size_t b = 0; b < 2; ++b) {
    std::vector<int> sorted = spread[b];
    std::sort(sorted.begin(), sorted.end());
    BOOST_TEST((std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()));
    for (const int node : sorted) {
      BOOST_TEST(rig.model().body_of(rig.model().unknown_of(node)) == static_cast<int>(b));
    }
  }
  // The small one has no more surface nodes than its corners and what lies between.
  BOOST_TEST(spread[1].size() >= 8U);
  BOOST_TEST(spread[0].size() + spread[1].size() <= rig.soft.surface_nodes.size());
}

BOOST_AUTO_TEST_SUITE_END()
