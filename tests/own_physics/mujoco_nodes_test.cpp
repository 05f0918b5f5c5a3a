// The nodes that step MuJoCo: physics, what brings its results to now, and the rollout in the device's loop.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "framework/core/segment.hpp"
#include "framework/core/value_error.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/interpolation/mujoco.hpp"
#include "nodes/own_physics/mujoco.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/prediction/mujoco.hpp"
#include "tests/own_physics/mujoco_models.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(mujoco_nodes_test, *boost::unit_test::precondition(tactor::test::NeedsMujoco{}))

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double substep = 2.5e-4;

/// The scene of a ball over a plane, and its model.
Scene ball_scene() {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies.resize(1);
  scene.bodies[0].name = "tool";
  scene.bodies[0].shape = SphereShape{0.01};
  scene.bodies[0].motion = Motion::translation;
  scene.bodies[0].mass = 0.05;
  return scene;
}
const Scene& the_scene() {
  static const Scene scene = ball_scene();
  return scene;
}
const std::filesystem::path& the_model() {
  static const std::filesystem::path file = model_file(plane + ball(slides, "0 0 0.02"), weightless);
  return file;
}

/// Defaults, but for the model, which a graph has to give, and the sub-step.
template <class N>
typename N::Params params_of() {
  typename N::Params params{};
  for (const ParamInfo& p : N::declare().params) {
    if (p.default_value) p.assign(&params, *p.default_value);
  }
  params.model = the_model();
  params.substep = substep;
  return params;
}

/// A handle that goes into the plane and along it.
DeviceState handle_at(int ms) {
  const double t = 1e-3 * ms;
  DeviceState d;
  d.X_WD.p = {0.02 * t, 0, 0.013 - 0.006 * std::sin(12 * t)};
  d.V_WD.v = {0.02, 0, -0.072 * std::cos(12 * t)};
  return d;
}

template <class N>
void give_sample(N& node, int ms) {
  const DeviceState d = handle_at(ms);
  node.device.push({at_ms(ms), at_ms(ms), static_cast<std::uint64_t>(ms)}, &d);
}

/// Physics with every sample of the handle.
class Physics {
 public:
  explicit Physics(const MujocoPhysics::Params& params = params_of<MujocoPhysics>())
      : node_(params, context_for(the_scene())) {
    node_.device.configure({QueuePolicy::drop_oldest, 4096});
    node_.coupling.configure({});
    node_.coupling.push({}, &stiff);
  }
  /// Goes on to that sample and returns its state.
  EngineState go_to(int ms) {
    for (; next_ <= ms; ++next_) give_sample(node_, next_);
    StepContext context(at_ms(ms));
    node_.step(context);
    BOOST_REQUIRE(node_.engine.pending() == 1U);
    BOOST_REQUIRE(node_.engine.pending_valid(0).ns == at_ms(ms).ns);
    const EngineState result = sent(node_.engine);
    state = sent(node_.state);
    bodies = sent(node_.bodies);
    node_.engine.clear_pending();
    node_.state.clear_pending();
    node_.bodies.clear_pending();
    node_.contacts.clear_pending();
    return result;
  }
  [[nodiscard]] Vec3 force() const { return coupling_wrench(stiff, state, false).force; }

  PhysicsState state;
  BodyStates bodies;

 private:
  MujocoPhysics node_;
  int next_ = 0;
};

/// The rollout with a state now and then.
class Display {
 public:
  explicit Display(const MujocoRollout::Params& params = params_of<MujocoRollout>())
      : node_(params, context_for(the_scene())) {
    node_.device.configure({QueuePolicy::drop_oldest, 64});
    node_.model.configure({});
  }
  void give(int result_ms, int ms, const EngineState& state) {
    node_.model.push({at_ms(result_ms), at_ms(ms), states_++}, &state);
  }
  bool tick(int ms) {
    give_sample(node_, ms);
    StepContext context(at_ms(ms));
    node_.step(context);
    if (node_.segment.pending() == 0) return false;
    shown = sent(node_.segment);
    node_.segment.clear_pending();
    return true;
  }
  [[nodiscard]] Vec3 force(int ms) const { return evaluate(shown, at_ms(ms)).force; }
  [[nodiscard]] double metric(const std::string& name) const { return metrics_of(node_).at(name); }

  ForceSegment shown;

 private:
  MujocoRollout node_;
  std::uint64_t states_ = 0;
};

bool same(const SharedArray<double>& a, const SharedArray<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

template <class Make>
std::string refusal(const Make& make) {
  try {
    make();
  } catch (const ValueError& error) {
    return error.path() + ": " + error.what();
  }
  return "taken";
}

}  // namespace

BOOST_AUTO_TEST_CASE(physics_starts_at_the_handle_and_stamps_its_results_as_samples) {
  Physics physics;
  const EngineState first = physics.go_to(0);
  BOOST_TEST(norm(physics.state.X_WT.p - handle_at(0).X_WD.p) < 1e-12);
  BOOST_TEST(first.position.size() == 3U);
  BOOST_TEST(first.activation.empty());
  const EngineState later = physics.go_to(130);
  BOOST_TEST(later.time.ns == at_ms(130).ns);
  BOOST_TEST(physics.state.contacts == 1);
  BOOST_TEST(physics.force().z > 1.0);
  BOOST_TEST(norm(later.wrench_result.force - physics.force()) == 0.0);
  BOOST_TEST(physics.bodies.count == 1);
  BOOST_TEST(norm(physics.bodies.X_WB[0].p - physics.state.X_WT.p) == 0.0);
  BOOST_TEST(norm(physics.bodies.V_WB[0].v - physics.state.V_WT.v) < 1e-12);
}

BOOST_AUTO_TEST_CASE(each_result_comes_with_its_contacts_and_states_that_are_dropped_are_counted) {
  MujocoPhysics node(params_of<MujocoPhysics>(), context_for(the_scene()));
  node.device.configure({QueuePolicy::drop_oldest, 4096});
  node.coupling.configure({});
  node.coupling.push({}, &stiff);
  std::vector<EngineState> held;
  for (int ms = 0; ms <= 130; ++ms) {
    give_sample(node, ms);
    StepContext context(at_ms(ms));
    node.step(context);
    BOOST_REQUIRE(node.contacts.pending() == 1U);
    BOOST_REQUIRE(node.contacts.pending_valid(0).ns == at_ms(ms).ns);
    const ContactSet set = sent(node.contacts);
    BOOST_REQUIRE(set.bodies.count == 1);
    if (ms == 0) BOOST_TEST(norm(set.bodies.X_WB[0].p - sent(node.state).X_WT.p) == 0.0);
    if (ms == 0) BOOST_TEST(set.count == 0);
    if (ms == 130) BOOST_TEST(set.count == 1);
    if (node.engine.pending() > 0) held.push_back(sent(node.engine));
    node.engine.clear_pending();
    node.contacts.clear_pending();
    node.state.clear_pending();
    node.bodies.clear_pending();
  }
  BOOST_TEST(held.size() >= most_engine_states);
  BOOST_TEST(held.size() < 131U);
  BOOST_TEST(metrics_of(node).at("dynamics_dropped_states") == static_cast<double>(131 - held.size()));
}

BOOST_AUTO_TEST_CASE(a_result_that_is_brought_to_now_is_physics_of_now_to_the_last_bit) {
  Physics late, now;
  MujocoPredictor predictor(params_of<MujocoPredictor>(), context_for(the_scene()));
  predictor.device.configure({QueuePolicy::drop_oldest, 2048});
  predictor.engine.configure({});
  for (int ms = 0; ms <= 150; ++ms) give_sample(predictor, ms);
  const EngineState result = late.go_to(120);
  predictor.engine.push(stamp_ms(120), &result);
  StepContext context(at_ms(150));
  predictor.step(context);
  BOOST_REQUIRE(predictor.model.pending() == 1U);
  BOOST_TEST(predictor.model.pending_valid(0).ns == at_ms(120).ns);
  const EngineState moved = sent(predictor.model), expected = now.go_to(150);
  BOOST_TEST(moved.time.ns == at_ms(150).ns);
  BOOST_TEST(same(moved.position, expected.position));
  BOOST_TEST(same(moved.velocity, expected.velocity));
  BOOST_TEST(same(moved.acceleration, expected.acceleration));
  BOOST_TEST(!same(moved.position, result.position));
  // What is told of the result stays that of the result.
  BOOST_TEST(norm(moved.wrench_result.force - result.wrench_result.force) == 0.0);
  BOOST_TEST(metrics_of(predictor).at("prediction.resimulated_steps") == 120.0);
  EngineState broken = result;
  broken.coupling.k_t = std::nan("");
  predictor.engine.push(stamp_ms(121, 1), &broken);
  predictor.model.clear_pending();
  predictor.step(context);
  BOOST_TEST(predictor.model.pending() == 0U);
  BOOST_TEST(metrics_of(predictor).at("prediction.rejected_results") == 1.0);
}

BOOST_AUTO_TEST_CASE(at_physics_own_step_the_rollout_shows_the_force_of_physics) {
  using Restart = MujocoRollout::Params::Restart;
  for (const Restart restart : {Restart::always, Restart::on_disagreement}) {
    auto params = params_of<MujocoRollout>();
    params.restart = restart;
    Physics truth, late, before;
    Display display(params);
    double worst = 0, largest = 0;
    for (int ms = 0; ms <= 600; ++ms) {
      truth.go_to(ms);
      // Every 10 ms a result of 10 ms ago, which is brought to the sample before this one.
      if (ms % 10 == 0 && ms > 0) {
        EngineState moved = before.go_to(ms - 1);
        moved.wrench_result = late.go_to(ms - 10).wrench_result;
        moved.p_WT_result = late.state.X_WT.p;
        display.give(ms - 10, ms, moved);
      }
      if (!display.tick(ms)) continue;
      worst = std::max(worst, norm(display.force(ms) - truth.force()));
      largest = std::max(largest, norm(truth.force()));
    }
    BOOST_TEST(largest > 2.0);
    // The scene is that of physics to the last bit. A result that it goes back to is blended in, and with it what the
    // tick before had foretold.
    BOOST_TEST(worst < (restart == Restart::always ? 0.02 * largest : 1e-9));
    BOOST_TEST(display.metric("rollout.estimated_error_N") < 1e-9);
    BOOST_TEST(display.metric("rollout.estimated_hold_error_N") > 0.01);
    BOOST_TEST(display.metric("fallbacks") == 0.0);
    BOOST_TEST(display.metric("rollout.moving_bodies") == 1.0);
  }
}

BOOST_AUTO_TEST_CASE(without_results_the_last_force_is_held_and_a_new_result_takes_over) {
  Physics physics;
  auto params = params_of<MujocoRollout>();
  params.trust_time = Duration::from_seconds(0.05);
  params.trust_time_max = Duration::from_seconds(0.05);
  Display display(params);
  BOOST_TEST(!display.tick(99));
  display.give(100, 100, physics.go_to(100));
  for (int ms = 100; ms < 200; ++ms) BOOST_REQUIRE(display.tick(ms));
  const Vec3 held = display.force(200);
  BOOST_TEST(norm(held) > 0.5);
  physics.go_to(149);
  BOOST_TEST(norm(held - physics.force()) < 1e-9);
  BOOST_TEST(display.metric("rollout.held_ticks") == 50.0);
  display.give(200, 200, physics.go_to(200));
  for (int ms = 200; ms < 240; ++ms) BOOST_REQUIRE(display.tick(ms));
  physics.go_to(239);
  BOOST_TEST(norm(display.force(239) - physics.force()) < 1e-6);
  BOOST_TEST(display.metric("rollout.ticks") == 90.0);
}

BOOST_AUTO_TEST_CASE(a_step_that_fails_holds_the_force_until_the_next_result) {
  Physics physics;
  MujocoRollout node(params_of<MujocoRollout>(), context_for(the_scene()));
  node.device.configure({QueuePolicy::drop_oldest, 64});
  node.model.configure({});
  const auto tick = [&](int ms, const DeviceState& d) {
    node.device.push({at_ms(ms), at_ms(ms), static_cast<std::uint64_t>(ms)}, &d);
    StepContext context(at_ms(ms));
    node.step(context);
    BOOST_REQUIRE(node.segment.pending() == 1U);
    const Vec3 force = evaluate(sent(node.segment), at_ms(ms)).force;
    node.segment.clear_pending();
    return force;
  };
  EngineState state = physics.go_to(100);
  node.model.push(stamp_ms(100, 0), &state);
  tick(100, handle_at(100));
  const Vec3 last = tick(101, handle_at(101));
  DeviceState far_away = handle_at(102);
  far_away.X_WD.p.x = 1e14;
  BOOST_TEST(norm(tick(102, far_away) - last) < 0.5);
  BOOST_TEST(metrics_of(node).at("rollout.failed_steps") == 1.0);
  BOOST_TEST(metrics_of(node).at("rollout.held_ticks") == 1.0);
  state = physics.go_to(103);
  node.model.push(stamp_ms(103, 1), &state);
  for (int ms = 103; ms < 140; ++ms) tick(ms, handle_at(ms));
  BOOST_TEST(metrics_of(node).at("rollout.held_ticks") == 1.0);
}

BOOST_AUTO_TEST_CASE(a_gap_in_the_samples_is_not_stepped_through_in_one_tick) {
  Physics physics;
  for (const double trust : {0.25, 10.0}) {
    auto params = params_of<MujocoRollout>();
    params.trust_time = params.trust_time_max = Duration::from_seconds(trust);
    Display display(params);
    const int begin = trust < 1 ? 100 : 3000, end = begin + 2010;
    display.give(begin, begin, physics.go_to(begin));
    for (int ms = begin; ms <= begin + 10; ++ms) BOOST_REQUIRE(display.tick(ms));
    const double steps = display.metric("rollout.steps");
    const Vec3 last = display.force(begin + 10);
    BOOST_REQUIRE(display.tick(end));
    BOOST_TEST(display.metric("rollout.steps") == steps);
    // A result that is old enough is not trusted, so no step is due.
    BOOST_TEST(display.metric("rollout.overruns") == (trust < 1 ? 0.0 : 1.0));
    BOOST_TEST(display.metric("rollout.held_ticks") == 1.0);
    BOOST_TEST(norm(display.force(end + 20) - last) < 0.2);
    display.give(end, end + 1, physics.go_to(end));
    for (int ms = end + 1; ms < end + 40; ++ms) BOOST_REQUIRE(display.tick(ms));
    physics.go_to(end + 39);
    BOOST_TEST(norm(display.force(end + 39) - physics.force()) < 1e-6);
    BOOST_TEST(display.metric("rollout.held_ticks") == 1.0);
  }
}

BOOST_AUTO_TEST_CASE(a_state_that_is_too_old_to_be_trusted_is_refused_as_late) {
  Physics physics;
  auto params = params_of<MujocoRollout>();
  params.trust_time = params.trust_time_max = Duration::from_seconds(0.05);
  Display display(params);
  display.give(100, 150, physics.go_to(100));
  BOOST_TEST(!display.tick(150));
  BOOST_TEST(display.metric("rollout.rejected_models") == 1.0);
  display.give(110, 151, physics.go_to(110));
  BOOST_TEST(display.tick(151));
  BOOST_TEST(display.metric("rollout.rejected_models") == 1.0);
}

BOOST_AUTO_TEST_CASE(a_scene_of_which_more_moves_than_the_tool_goes_back_to_every_result) {
  const auto with_box = model_file(plane + ball(slides, "0 0 0.02") + R"(<body pos="0.2 0 0.02"><freejoint/>
      <geom type="box" size="0.02 0.02 0.02" mass="0.1"/></body>)",
                                   weightless);
  for (const bool box : {false, true}) {
    auto of_physics = params_of<MujocoPhysics>();
    auto params = params_of<MujocoRollout>();
    if (box) of_physics.model = params.model = with_box;
    // Another sub-step, so that going back changes the force.
    params.substep = 5e-4;
    params.restart = MujocoRollout::Params::Restart::on_disagreement;
    Physics physics(of_physics);
    Display display(params);
    display.give(100, 100, physics.go_to(100));
    for (int ms = 100; ms <= 130; ++ms) BOOST_REQUIRE(display.tick(ms));
    display.give(130, 131, physics.go_to(130));
    BOOST_REQUIRE(display.tick(131));
    BOOST_TEST((display.metric("rollout.correction_rms_N") > 0) == box);
    BOOST_TEST(display.metric("rollout.disagreements") == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(a_result_older_than_all_samples_that_are_known_is_refused_as_late) {
  Physics physics;
  MujocoPredictor predictor(params_of<MujocoPredictor>(), context_for(the_scene()));
  predictor.device.configure({QueuePolicy::drop_oldest, 2048});
  predictor.engine.configure({});
  StepContext context(at_ms(3000));
  for (int ms = 0; ms <= 3000; ++ms) {
    give_sample(predictor, ms);
    if (ms % 1000 == 0) predictor.step(context);
  }
  const EngineState old = physics.go_to(500), fresh = physics.go_to(2990);
  predictor.engine.push(stamp_ms(500), &old);
  predictor.step(context);
  BOOST_TEST(predictor.model.pending() == 0U);
  BOOST_TEST(predictor.refusals().refused(RefusalReason::late) == 1U);
  predictor.engine.push(stamp_ms(2990, 1), &fresh);
  predictor.step(context);
  BOOST_TEST(predictor.model.pending() == 1U);
  BOOST_TEST(predictor.refusals().refused() == 1U);
}

BOOST_AUTO_TEST_CASE(the_force_stays_within_the_limit_of_the_coupling) {
  Physics physics;
  EngineState state = physics.go_to(100);
  state.coupling.force_max = 0.5;
  Display display;
  display.give(100, 100, state);
  for (int ms = 100; ms < 140; ++ms) {
    BOOST_REQUIRE(display.tick(ms));
    BOOST_TEST(norm(display.force(ms)) < 0.5 + 1e-9);
  }
  physics.go_to(130);
  BOOST_TEST(norm(physics.force()) > 1.0);
}

BOOST_AUTO_TEST_CASE(physics_that_becomes_unstable_ends_the_run_and_names_the_node) {
  MujocoPhysics node(params_of<MujocoPhysics>(), context_for(the_scene()));
  node.device.configure({QueuePolicy::drop_oldest, 4096});
  node.coupling.configure({});
  node.coupling.push({}, &stiff);
  give_sample(node, 0);
  DeviceState far_away;
  far_away.X_WD.p = {1e14, 0, 0};
  node.device.push(stamp_ms(1, 1), &far_away);
  StepContext context(at_ms(1));
  const auto says_so = [](const RunError& error) {
    const std::string text = error.what();
    return text.starts_with("node test: MuJoCo cannot go on") && text.find("unstable") != std::string::npos;
  };
  BOOST_CHECK_EXCEPTION(node.step(context), RunError, says_so);
}

BOOST_AUTO_TEST_CASE(a_scene_that_does_not_go_with_the_model_is_refused_at_its_place) {
  const auto made_with = [](const auto& change) {
    return refusal([&] {
      Scene scene = ball_scene();
      change(scene);
      MujocoPhysics(params_of<MujocoPhysics>(), context_for(scene));
    });
  };
  const auto begins = [](const std::string& text, const std::string& with) {
    BOOST_TEST(text.starts_with(with), text);
  };
  BOOST_TEST(made_with([](Scene&) {}) == "taken");
  begins(made_with([](Scene& s) { s.bodies[0].mass = 0.06; }), "scene.bodies.tool.mass: ");
  begins(made_with([](Scene& s) { s.bodies[0].motion = Motion::rigid; }), "scene.bodies.tool.motion: ");
  begins(made_with([](Scene& s) { s.gravity_W.z = -9.81; }), "scene.gravity: ");
  const auto one_more = [](const std::string& name) {
    return [name](Scene& s) {
      s.bodies.push_back(s.bodies[0]);
      s.bodies.back().name = name;
    };
  };
  begins(made_with(one_more("other")), "scene.bodies.other: ");
  begins(made_with(one_more("world")), "scene.bodies.world.motion: ");
  const auto turned = [](double inertia) {
    return refusal([&] {
      Scene scene = ball_scene();
      scene.bodies[0].motion = Motion::rigid;
      scene.bodies[0].inertia = inertia * Vec3{1, 1, 1};
      auto params = params_of<MujocoPhysics>();
      params.model = model_file(ball("<freejoint/>"), weightless);
      MujocoPhysics(params, context_for(scene));
    });
  };
  // Of the ball, 2/5 m r^2.
  BOOST_TEST(turned(0.4 * 0.05 * 0.01 * 0.01) == "taken");
  BOOST_TEST(turned(1.04 * 0.4 * 0.05 * 0.01 * 0.01) == "taken");
  begins(turned(1.06 * 0.4 * 0.05 * 0.01 * 0.01), "scene.bodies.tool.inertia: ");
  begins(refusal([] {
           auto params = params_of<MujocoRollout>();
           params.model.clear();
           MujocoRollout(params, context_for(the_scene()));
         }),
         "model: ");
}

BOOST_AUTO_TEST_CASE(a_state_of_another_model_of_the_same_size_is_refused) {
  auto params = params_of<MujocoPhysics>();
  params.model = model_file(plane + ball(slides, "0 0 0.03"), weightless);
  Physics other(params), own;
  Display display;
  display.give(100, 100, other.go_to(100));
  BOOST_TEST(!display.tick(100));
  BOOST_TEST(display.metric("rollout.rejected_models") == 1.0);
  display.give(101, 101, own.go_to(101));
  BOOST_TEST(display.tick(101));
}

BOOST_AUTO_TEST_CASE(moving_bodies_that_the_scene_does_not_name_are_noted) {
  auto params = params_of<MujocoPhysics>();
  params.model = model_file(ball(slides) + R"(<body name="box" pos="0 0 1"><freejoint/>
      <geom type="box" size="0.02 0.02 0.02"/></body>)",
                            weightless);
  std::vector<std::string> notes;
  NodeContext context = context_for(the_scene());
  context.notes = &notes;
  MujocoPhysics physics(params, context);
  BOOST_REQUIRE(notes.size() == 1U);
  BOOST_TEST(notes[0].find("not in the scene: box.") != std::string::npos, notes[0]);
}

BOOST_AUTO_TEST_CASE(in_each_tick_the_scene_goes_on_from_the_first_result_to_the_last_bit) {
  auto params = params_of<MujocoRollout>();
  params.mode = MujocoRollout::Params::Mode::each_tick;
  // Without effect: no result but the first is needed.
  params.trust_time = params.trust_time_max = Duration::from_seconds(0.05);
  Physics truth, first;
  Display display(params);
  // The first result is 20 samples old when it comes.
  for (int ms = 20; ms < 40; ++ms) BOOST_TEST(!display.tick(ms));
  display.give(20, 40, first.go_to(20));
  double worst = 0, largest = 0;
  for (int ms = 40; ms <= 600; ++ms) {
    BOOST_REQUIRE(display.tick(ms));
    truth.go_to(ms);
    // By then, what was shown at the begin has decayed.
    if (ms < 120) continue;
    worst = std::max(worst, norm(display.force(ms) - truth.force()));
    largest = std::max(largest, norm(truth.force()));
  }
  BOOST_TEST(largest > 2.0);
  BOOST_TEST(worst < 1e-9);
  BOOST_TEST(display.metric("rollout.failed_steps") == 0.0);
  BOOST_TEST(display.metric("rollout.held_ticks") < 10.0);
}

BOOST_AUTO_TEST_CASE(each_tick_is_refused_where_the_steps_of_a_tick_are_measured_not_to_fit) {
  auto params = params_of<MujocoRollout>();
  params.mode = MujocoRollout::Params::Mode::each_tick;
  params.rate = 1e7;
  params.substep = 1e-5;
  const auto made = [&](bool wall_clock) {
    return refusal([&] {
      NodeContext context = context_for(the_scene());
      context.wall_clock = wall_clock;
      MujocoRollout(params, context);
    });
  };
  // The virtual clock decides nothing by the speed of the machine.
  BOOST_TEST(made(false) == "taken");
  const std::string text = made(true);
  BOOST_TEST(text.starts_with("mode: interpolation.mujoco: the steps of "), text);
  BOOST_TEST(text.find(" us of CPU time on this machine") != std::string::npos, text);
}

BOOST_AUTO_TEST_CASE(bodies_out_of_reach_stand_in_the_rollout_and_are_counted) {
  const auto with_boxes = model_file(plane + ball(slides, "0 0 0.02") + R"(
      <body pos="0.03 0 0.02"><freejoint/><geom type="box" size="0.01 0.01 0.02" mass="0.1"/></body>
      <body pos="0.9 0 0.02"><freejoint/><geom type="box" size="0.02 0.02 0.02" mass="0.1"/></body>)",
                                     weightless);
  for (const double budget : {1.0, 0.0}) {
    auto of_physics = params_of<MujocoPhysics>();
    auto of_predictor = params_of<MujocoPredictor>();
    auto params = params_of<MujocoRollout>();
    of_physics.model = of_predictor.model = params.model = with_boxes;
    of_predictor.budget = budget;
    Physics physics(of_physics);
    MujocoPredictor predictor(of_predictor, context_for(the_scene()));
    predictor.device.configure({QueuePolicy::drop_oldest, 2048});
    predictor.engine.configure({});
    for (int ms = 0; ms <= 120; ++ms) give_sample(predictor, ms);
    const EngineState result = physics.go_to(100);
    BOOST_TEST((result.moving == all_trees));
    predictor.engine.push(stamp_ms(100), &result);
    StepContext context(at_ms(120));
    predictor.step(context);
    BOOST_REQUIRE(predictor.model.pending() == 1U);
    const EngineState moved = sent(predictor.model);
    BOOST_TEST((moved.moving == (budget > 0 ? 3U : 1U)));
    BOOST_TEST(metrics_of(predictor).count("prediction.cost_ratio") == 0U);
    Display display(params);
    display.give(100, 120, moved);
    BOOST_REQUIRE(display.tick(120));
    BOOST_TEST(display.metric("rollout.moving_bodies") == (budget > 0 ? 2.0 : 1.0));
    BOOST_TEST(display.metric("rollout.most_moving_bodies") == (budget > 0 ? 2.0 : 1.0));
  }
}

BOOST_AUTO_TEST_CASE(the_rollout_allocates_nothing, *boost::unit_test::precondition(heap_is_counted)) {
  Physics physics;
  const EngineState first = physics.go_to(100), second = physics.go_to(110);
  Display display;
  display.give(100, 100, first);
  for (int ms = 100; ms < 120; ++ms) BOOST_REQUIRE(display.tick(ms));
  display.give(110, 120, second);
  std::int64_t calls = 0;
  bool shown = true;
  for (int ms = 120; ms < 160; ++ms) {
    const std::int64_t before = thread_heap_calls();
    shown = display.tick(ms) && shown;
    calls += thread_heap_calls() - before;
  }
  BOOST_TEST(calls == 0);
  BOOST_TEST(shown);
}

BOOST_AUTO_TEST_SUITE_END()
