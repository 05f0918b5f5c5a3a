// What is told of a scene before anything has moved, against distances worked out by hand.
#include "nodes/physics/contact/doubts.hpp"

#include <boost/test/unit_test.hpp>

#include "framework/core/check.hpp"
#include "nodes/collision/primitive.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"

BOOST_AUTO_TEST_SUITE(doubts_test)

using namespace tactor;
using namespace tactor::test;

namespace {

Body at(Body body, const Vec3& p_WB) {
  body.X_WB.p = p_WB;
  return body;
}

HandPath line(const Vec3& from, const Vec3& to) {
  HandPath path;
  for (int i = 0; i <= 1000; ++i) path.X_WH.push_back({from + (i / 1000.0) * (to - from), {}});
  return path;
}

/// What collision.primitive tells of bodies and a path; null: nobody knows the path.
std::vector<std::string> told(std::vector<Body> bodies, const HandPath* hand, double spacing = 0) {
  Scene scene;
  scene.bodies = std::move(bodies);
  NodeContext context = context_for(scene);
  std::vector<std::string> notes;
  context.notes = &notes;
  context.hand = hand;
  PrimitiveCollision::Params params = default_params<PrimitiveCollision>();
  params.spacing = spacing;
  const PrimitiveCollision node(params, context);
  return notes;
}

const Body tool = ball("tool", 0.004, Motion::translation);
const Body wall = shaped("wall", PlaneShape{});
const Body block = shaped("block", BoxShape{{0.02, 0.02, 0.02}});

bool has(const std::vector<std::string>& notes, const std::string& text) {
  return std::any_of(notes.begin(), notes.end(), [&](const auto& n) { return n.find(text) != std::string::npos; });
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_path_that_passes_all_bodies_is_told_with_its_distance) {
  // 15 mm above the plane, less the radius of 4 mm; the steps of the path are 0.03 mm.
  const HandPath above = line({0, 0, 0.015}, {0.03, 0, 0.015});
  const std::vector<std::string> notes = told({wall, tool}, &above);
  BOOST_REQUIRE(notes.size() == 1U);
  BOOST_TEST(has(notes, "the hand does not lead the tool 'tool' to any body: it keeps 11 mm away"), notes[0]);
  // Beside the corner of a box of 10 mm about the origin: sqrt(2) * 10 mm away, less the radius.
  const HandPath beside = line({0.02, 0.02, -0.05}, {0.02, 0.02, 0.05});
  BOOST_TEST(has(told({block, tool}, &beside), "it keeps 10 mm away"));
  // Turned by 45 degrees its corner is at sqrt(2) * 10 mm and the way leads past its flat side.
  Body turned = block;
  turned.X_WB.R = from_rotation_vector({0, 0, 0.78539816339744831});
  BOOST_TEST(has(told({turned, tool}, &beside), "it keeps 14 mm away"));
}

BOOST_AUTO_TEST_CASE(a_path_that_may_touch_is_not_told) {
  const HandPath down = line({0, 0, 0.015}, {0, 0, 0.003});
  BOOST_TEST(told({wall, tool}, &down).empty());
  // Without a path nothing is known, and another body that moves may come to the tool.
  BOOST_TEST(told({wall, tool}, nullptr).empty());
  const HandPath above = line({0, 0, 0.015}, {0.03, 0, 0.015});
  BOOST_TEST(told({wall, tool, at(ball("other", 0.004, Motion::translation), {0.1, 0, 0.05})}, &above).empty());
}

BOOST_AUTO_TEST_CASE(a_path_beyond_a_hundred_bodies_is_told) {
  // The longest body is the block of 20 mm; 2 m from its side is a hundred of it.
  const HandPath out = line({0.012, 0, 0}, {2.0, 0, 0}), far_out = line({0.012, 0, 0}, {2.1, 0, 0});
  BOOST_TEST(!has(told({block, tool}, &out), "leaves the scene"));
  BOOST_TEST(has(told({block, tool}, &far_out),
                 "leaves the scene: it goes 2.1 m away from all bodies, and the longest of them is 20 mm"));
}

BOOST_AUTO_TEST_CASE(a_start_inside_a_body_is_told_with_its_depth) {
  // The ball's centre on the plane: a radius deep.
  const HandPath along = line({0, 0, 0}, {0.03, 0, 0});
  BOOST_TEST(has(told({wall, tool}, &along), "the body 'tool' starts 4 mm inside the body 'wall'"));
  // A touch of less than a third of the ball is how a run may begin.
  const HandPath light = line({0, 0, 0.0014}, {0.03, 0, 0.0014});
  BOOST_TEST(told({wall, tool}, &light).empty());
  // Not only the tool: a block that stands half in the wall.
  Body moving = at(block, {0.1, 0, 0.0025});
  moving.motion = Motion::translation;
  const HandPath above = line({0, 0, 0.015}, {0, 0, 0.003});
  BOOST_TEST(has(told({wall, tool, moving}, &above), "the body 'block' starts 7.5 mm inside the body 'wall'"));
}

BOOST_AUTO_TEST_CASE(a_spacing_beyond_a_quarter_of_a_body_is_told) {
  const Body cube = at(shaped("cube", BoxShape{{0.016, 0.008, 0.008}}, Motion::translation), {0, 0, 0.05});
  BOOST_TEST(told({wall, cube}, nullptr, 0.004).empty());
  BOOST_TEST(
      has(told({wall, cube}, nullptr, 0.0042),
          "body 'cube': warning: a spacing of contact samples of 4.2 mm is large for a body that is 16 mm long"));
  const Body pen = at(shaped("pen", CapsuleShape{0.003, 0.05}, Motion::translation), {0, 0, 0.05});
  BOOST_TEST(told({wall, pen}, nullptr, 0.003).empty());
  BOOST_TEST(has(told({wall, pen}, nullptr, 0.0035), "body 'pen': warning"));
  // A ball has one sample, whatever the spacing.
  BOOST_TEST(told({wall, tool}, nullptr, 0.5).empty());
}

BOOST_AUTO_TEST_SUITE_END()
