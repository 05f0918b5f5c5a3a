// A ball that slides and comes down on a soft block, as the local rollout goes on from a result and as the whole body
// does.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>

#include "nodes/physics/deformable/condensation.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"
#include "tests/nodes/physics/deformable/soft_rig.hpp"

BOOST_AUTO_TEST_SUITE(local_slide_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double tick = 0.001;    // s
constexpr double radius = 0.008;  // m

class BallContacts final : public SoftContactSource {
 public:
  explicit BallContacts(const Scene& scene)
      : contacts_(scene, {.soft_contacts = 128, .soft_work = 100'000}, cell_distances({}, nullptr)) {}
  [[nodiscard]] int deformable() const override { return 1; }
  bool find_on(const SoftFaces& faces, std::span<const Vec3> nodes_W, const Pose& X_WT,
               std::vector<SoftContact>& found) override {
    return contacts_.find_on(faces.node, faces.body, faces.area, nodes_W, X_WT, found);
  }

 private:
  SoftContacts contacts_;
};

Scene ball_on_gel(const Vec3& p_WT, double young, double friction) {
  Scene scene;
  scene.gravity_W = {};
  Body gel = gel_box("gel", {0.08, 0.08, 0.04}, {}, young, 0.012);
  gel.deformable.poisson = 0.45;
  gel.deformable.damping = 0.005;
  hold_bottom(gel);
  Body tool = ball_tool(radius, p_WT, 0.05);
  gel.material.damping = tool.material.damping = 1;
  gel.material.friction = tool.material.friction = friction;
  scene.bodies = {gel, tool};
  return scene;
}

/// A hand that goes down at `down` m/s for a time and then along x at `along` m/s.
struct Hand {
  Vec3 start;
  double down = 0, until = 0, along = 0;
  [[nodiscard]] DeviceState at(double t) const {
    DeviceState device;
    device.X_WD.p = start + Vec3{along * std::max(0.0, t - until), 0, -down * std::min(t, until)};
    device.V_WD.v = t < until ? Vec3{0, 0, -down} : Vec3{along, 0, 0};
    return device;
  }
};

/// N, the most by which the spring's force goes off that of the whole body over `ticks`, which step on alike from
/// `until`.
double off(SoftRig& rig, const Hand& hand, double until, int ticks) {
  rig.coupling.k_t = 1000;
  rig.coupling.b_t = 7;
  rig.coupling.force_max = 100;
  double t = 0;
  while (t < until - 1e-9) rig.advance(tick, hand.at(t += tick));
  Condensation condensation(*rig.step, 4);
  rig.step->refresh(rig.bodies);
  const auto patch = condensation.condense();
  BOOST_REQUIRE(patch.has_value());
  BallContacts contacts(rig.scene);
  LocalRollout rollout(rig_model(rig.scene, {}), nullptr, &contacts);
  LocalModel model;
  model.device = hand.at(t);
  model.bodies = rig.bodies;
  model.coupling = rig.coupling;
  model.patch = *patch;
  BOOST_REQUIRE(rollout.restart(model));
  double worst = 0;
  for (int k = 1; k <= ticks; ++k) {
    const DeviceState device = hand.at(t += tick);
    rig.advance(tick, device);
    BOOST_TEST(rollout.advance({.stamp = {.valid = Time::from_seconds(k * tick)}, .value = device}));
    const auto force = [&](const BodyStates& bodies) {
      const PhysicsState state{
          .X_WT = bodies.X_WB[0], .V_WT = bodies.V_WB[0], .X_WD = device.X_WD, .V_WD = device.V_WD};
      return coupling_wrench(rig.coupling, state, false).force;
    };
    worst = std::max(worst, norm(force(rollout.model().bodies) - force(rig.bodies)));
  }
  BOOST_TEST_MESSAGE("off by " << worst << " N in " << ticks << " ticks");
  return worst;
}

const RigOptions fine{.tolerance = 1e-7, .reuse = true, .far_nodes = 8};

}  // namespace

BOOST_AUTO_TEST_CASE(a_tool_that_slides_is_pushed_as_by_the_whole_body) {
  // 1.8 N. Contacts found where a tick begins have normals that are v h / r off, 0.01 to 0.03 N.
  for (const double friction : {0.0, 0.3}) {
    for (const double speed : {0.01, 0.044, 0.1}) {
      SoftRig rig(ball_on_gel({-0.01, 0, 0.03}, 2e4, friction), fine);
      const Hand hand{.start = {-0.01, 0, 0.03}, .down = 0.03, .until = 0.3, .along = speed};
      BOOST_TEST(off(rig, hand, 0.45, 2) < 0.002);
    }
  }
  SoftRig rig(ball_on_gel({-0.01, 0, 0.03}, 2e4, 0.3), fine);
  BOOST_TEST(off(rig, {.start = {-0.01, 0, 0.03}, .down = 0.03, .until = 0.3, .along = 0.044}, 0.45, 32) < 0.01);
}

BOOST_AUTO_TEST_CASE(a_tool_that_comes_down_fast_is_stopped_as_by_the_whole_body) {
  // From before it touches, to 2 N and more.
  for (const double young : {5e3, 2e4}) {
    SoftRig rig(ball_on_gel({0, 0, 0.03}, young, 0.3), fine);
    BOOST_TEST(off(rig, {.start = {0, 0, 0.03}, .down = 0.3, .until = 0.03, .along = 0}, 0.01, 30) < 0.15);
  }
}

BOOST_AUTO_TEST_SUITE_END()
