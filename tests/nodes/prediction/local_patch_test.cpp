// prediction.local where something deforms: only the patch of the result at hand serves.
#include <boost/test/unit_test.hpp>

#include <limits>
#include <map>
#include <string>

#include "nodes/physics/mechanics/local_model.hpp"
#include "nodes/prediction/local.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"
#include "tests/nodes/physics/mechanics/patches.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(local_patch_test)

using namespace tactor;
using namespace tactor::test;

namespace {

Scene ball_on_gel() {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies.resize(2);
  scene.bodies[0].name = "gel";
  scene.bodies[0].shape = BoxShape{{0.08, 0.08, 0.04}};
  scene.bodies[0].motion = Motion::deformable;
  scene.bodies[1].name = "tool";
  scene.bodies[1].shape = SphereShape{0.01};
  scene.bodies[1].motion = Motion::translation;
  return scene;
}

/// Three nodes that a face lies over, below a ball at the origin.
LocalPatch pad(PatchPool& pool, double depth) {
  RandomPatch random(3, 1);
  random.f.setZero();
  random.u.setZero();
  random.places << -0.01, -0.01, depth - 0.01, 0.02, -0.01, depth - 0.01, -0.01, 0.02, depth - 0.01;
  return random.make(pool, 1, 0.002, 0, {{.node = {0, 1, 2}, .body = 0, .area = 4.5e-4}});
}

class Subject {
 public:
  Subject() : node_(default_params<LocalPredictor>(), context_for(scene_)) {
    node_.bodies.configure({});
    node_.patch.configure({});
    node_.coupling.configure({});
    node_.device.configure({QueuePolicy::drop_oldest, 64});
    const CouplingParameters coupling{.k_t = 500, .b_t = 14, .force_max = 8, .torque_max = 0.3};
    node_.coupling.push({}, &coupling);
    for (int ms = 0; ms <= 40; ++ms) {
      const DeviceState device;
      node_.device.push(stamp_ms(ms), &device);
    }
  }
  void patch(int ms, const LocalPatch& patch) { node_.patch.push(stamp_ms(ms), &patch); }
  /// True where a model is sent for the result of that time.
  bool result(int ms) {
    const BodyStates bodies = one_body({});
    Stamp stamp = stamp_ms(ms);
    stamp.sequence = sequence_++;
    node_.bodies.push(stamp, &bodies);
    StepContext context(Time{40'000'000});
    node_.step(context);
    const bool any = node_.model.pending() > 0;
    if (any) model = sent(node_.model);
    node_.model.clear_pending();
    return any;
  }
  [[nodiscard]] double metric(const std::string& name) const { return metrics_of(node_).at(name); }
  LocalModel model;

 private:
  Scene scene_ = ball_on_gel();
  LocalPredictor node_;
  std::uint64_t sequence_ = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_result_without_its_own_patch_sends_nothing_and_is_counted) {
  PatchPool pool;
  Subject subject;
  BOOST_TEST(!subject.result(10));
  BOOST_TEST(subject.metric("prediction.rejected_results") == 1.0);
  subject.patch(10, pad(pool, 0.001));
  BOOST_TEST(!subject.result(20));
  BOOST_TEST(subject.metric("prediction.rejected_results") == 2.0);
  subject.patch(20, pad(pool, 0.001));
  BOOST_TEST(subject.result(20));
  BOOST_TEST(subject.metric("prediction.rejected_results") == 2.0);
  BOOST_TEST(subject.metric("prediction.resimulated_steps") == 20.0);
}

BOOST_AUTO_TEST_CASE(what_deforms_is_moved_on_with_the_tool) {
  PatchPool pool;
  Subject subject;
  subject.patch(20, pad(pool, 0.001));
  BOOST_REQUIRE(subject.result(20));
  // Pressed by the ball, the face goes down, and the ball up.
  BOOST_REQUIRE(subject.model.patch.modes.size() == 9U);
  double moved = 0;
  for (int i = 0; i < 3; ++i) {
    for (std::size_t m = 0; m < 9; ++m) {
      moved += subject.model.patch.shapes[m * 9 + static_cast<std::size_t>(3 * i + 2)] * subject.model.patch.modes[m].z;
    }
  }
  BOOST_TEST(moved < -1e-6);
  BOOST_TEST(subject.model.bodies.X_WB[0].p.z > 1e-6);
  // Apart, neither moves.
  subject.patch(30, pad(pool, -0.005));
  BOOST_REQUIRE(subject.result(30));
  for (const PatchMode& mode : subject.model.patch.modes) BOOST_TEST(std::abs(mode.z) < 1e-15);
  BOOST_TEST(norm(subject.model.bodies.X_WB[0].p) < 1e-15);
}

BOOST_AUTO_TEST_CASE(a_patch_that_cannot_be_is_refused_and_counted) {
  PatchPool pool;
  Subject subject;
  const LocalPatch good = pad(pool, 0.001);
  const std::vector<PatchNode> nodes(good.nodes.begin(), good.nodes.end());
  const std::vector<PatchMode> modes(good.modes.begin(), good.modes.end());
  const Eigen::MatrixXd shapes = Eigen::Map<const Eigen::MatrixXd>(good.shapes.data(), 9, 9);
  const std::vector<PatchFace> foreign{{.node = {0, 1, 2}, .body = 1, .area = 1e-4}};
  const std::vector<PatchFace> beyond{{.node = {0, 1, 3}, .body = 0, .area = 1e-4}};
  std::vector<PatchMode> unstable = modes;
  unstable[0].stiffness = -1;
  const std::vector<PatchFace> faces(good.faces.begin(), good.faces.end());
  int refused = 0;
  for (const LocalPatch& bad :
       {pool.patch(nodes, foreign, modes, shapes), pool.patch(nodes, beyond, modes, shapes),
        pool.patch(nodes, faces, unstable, shapes), pool.patch(nodes, faces, modes, shapes.leftCols(8)),
        pool.patch(nodes, faces, modes, shapes * std::numeric_limits<double>::quiet_NaN())}) {
    subject.patch(20, bad);
    BOOST_TEST(!subject.result(20));
    BOOST_TEST(subject.metric("prediction.rejected_results") == static_cast<double>(++refused));
  }
  subject.patch(20, good);
  BOOST_TEST(subject.result(20));
}

BOOST_AUTO_TEST_SUITE_END()
