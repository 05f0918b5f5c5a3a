// The nodes that step a program's light copy: from a result to now, and on in the device's loop.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include "framework/core/handle_between.hpp"
#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/interpolation/external.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/prediction/external.hpp"
#include "tests/own_physics/mass_and_wall.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(copy_nodes_test)

using namespace tactor;
using namespace tactor::test;

namespace {

const CouplingParameters spring{.k_t = 1000, .b_t = 14, .k_r = 1, .b_r = 0.004, .force_max = 8, .torque_max = 0.3};

const Scene& mass_scene() {
  static const Scene scene = [] {
    Scene made;
    made.bodies.resize(1);
    made.bodies[0].name = "tool";
    made.bodies[0].shape = SphereShape{MassAndWall::radius};
    made.bodies[0].motion = Motion::translation;
    made.bodies[0].mass = MassAndWall::mass;
    return made;
  }();
  return scene;
}

/// A handle that goes into the wall and along it.
Stamped<DeviceState> sample_at(int ms) {
  const double t = 1e-3 * ms;
  DeviceState d;
  d.X_WD.p = {0.02 * t, 0, 6e-3 - 6e-3 * std::sin(12 * t)};
  d.V_WD.v = {0.02, 0, -0.072 * std::cos(12 * t)};
  return {stamp_ms(ms, static_cast<std::uint64_t>(ms)), d};
}

/// The program's physics through every sample of the handle, in four sub-steps each.
class MassPhysics {
 public:
  MassPhysics() {
    const Vec3 p = sample_at(0).value.X_WD.p;
    state_ = {p.x, p.y, p.z};
  }
  EngineState go_to(int ms) {
    for (; now_ < ms; ++now_) {
      const DeviceState from = sample_at(now_).value, to = sample_at(now_ + 1).value;
      for (double k = 1; k <= 4; ++k) {
        MassAndWall::step(state_, {2.5e-4, handle_between(from, to, k / 4, false), spring});
      }
    }
    const CopyTool tool = MassAndWall::tool(state_);
    const DeviceState device = sample_at(ms).value;
    const PhysicsState then{.X_WT = tool.X_WT, .V_WT = tool.V_WT, .X_WD = device.X_WD, .V_WD = device.V_WD};
    force = coupling_wrench(spring, then, false).force;
    EngineState result;
    result.identity = MassAndWall::numbers;
    result.time = at_ms(ms);
    result.device = device;
    result.X_WT = tool.X_WT;
    result.V_WT = tool.V_WT;
    result.p_WT_result = tool.X_WT.p;
    result.wrench_result.force = force;
    result.coupling = spring;
    result.position = pool_.copy(state_).value();
    return result;
  }

  Vec3 force;

 private:
  int now_ = 0;
  std::array<double, MassAndWall::numbers> state_{};
  ArrayPool<double> pool_{64, MassAndWall::numbers};
};

/// Both nodes, with a copy unless `step` is empty.
class CopyMethod {
 public:
  explicit CopyMethod(const CopyFunction& step = MassAndWall::step)
      : resimulation_(default_params<ExternalPredictor>(), context_for(mass_scene())),
        rollout_(default_params<ExternalRollout>(), context_for(mass_scene())) {
    resimulation_.device.configure({QueuePolicy::drop_oldest, 2048});
    resimulation_.engine.configure({});
    rollout_.device.configure({QueuePolicy::drop_oldest, 64});
    rollout_.model.configure({});
    if (!step) return;
    const LightCopy copy{MassAndWall::numbers, step};
    resimulation_.take_copy(copy);
    rollout_.take_copy(copy);
  }
  /// A result of `result_ms` is there at `ms`, and is brought to then.
  void give(int result_ms, int ms, const EngineState& result) {
    resimulation_.engine.push({at_ms(result_ms), at_ms(ms), results_}, &result);
    StepContext context(at_ms(ms));
    resimulation_.step(context);
    if (resimulation_.model.pending() == 0) return;
    rollout_.model.push({at_ms(result_ms), at_ms(ms), results_++}, &sent(resimulation_.model));
    resimulation_.model.clear_pending();
  }
  void give_to_rollout(int ms, const EngineState& state) {
    rollout_.model.push({at_ms(ms), at_ms(ms), results_++}, &state);
  }
  void sample(int ms) {
    const Stamped<DeviceState> device = sample_at(ms);
    resimulation_.device.push(device.stamp, &device.value);
    rollout_.device.push(device.stamp, &device.value);
  }
  bool tick(int ms) {
    StepContext context(at_ms(ms));
    rollout_.step(context);
    if (rollout_.segment.pending() == 0) return false;
    shown_ = sent(rollout_.segment);
    rollout_.segment.clear_pending();
    return true;
  }
  [[nodiscard]] Vec3 force(int ms) const { return evaluate(shown_, at_ms(ms)).force; }
  [[nodiscard]] double metric(const std::string& name) const {
    const auto metrics = name.starts_with("prediction.") ? metrics_of(resimulation_) : metrics_of(rollout_);
    return metrics.at(name);
  }

 private:
  ExternalPredictor resimulation_;
  ExternalRollout rollout_;
  ForceSegment shown_;
  std::uint64_t results_ = 0;
};

/// Checks for an error with that text; who runs the node adds its name.
auto says(const std::string& part) {
  return [part](const RunError& error) {
    const std::string text = error.what();
    BOOST_TEST_MESSAGE(text);
    return text.find(part) != std::string::npos;
  };
}

}  // namespace

BOOST_AUTO_TEST_CASE(with_the_steps_of_physics_the_copy_has_the_force_of_physics) {
  MassPhysics truth, late;
  CopyMethod method;
  double worst = 0, largest = 0;
  for (int ms = 0; ms <= 600; ++ms) {
    method.sample(ms);
    truth.go_to(ms);
    // 60 results a second, each 16 ms late.
    if (ms >= 17 && ms % 17 == 0) method.give(ms - 16, ms, late.go_to(ms - 16));
    if (!method.tick(ms)) continue;
    worst = std::max(worst, norm(method.force(ms) - truth.force));
    largest = std::max(largest, norm(truth.force));
  }
  BOOST_TEST(largest > 2.0);
  BOOST_TEST(worst < 0.03 * largest);
  // At the times of the results.
  BOOST_TEST(method.metric("rollout.estimated_error_N") < 1e-9);
  BOOST_TEST(method.metric("rollout.estimated_hold_error_N") > 0.01);
  for (const char* none :
       {"fallbacks", "rollout.failed_steps", "rollout.rejected_models", "prediction.rejected_results"}) {
    BOOST_TEST(method.metric(none) == 0.0, none);
  }
  BOOST_TEST(method.metric("prediction.resimulated_steps") == 64.0);
}

BOOST_AUTO_TEST_CASE(each_node_has_a_function_of_its_own) {
  std::set<const void*> used;
  struct Noting {
    std::set<const void*>* used;
    CopyTool operator()(std::span<double> state, const CopyStep& step) const {
      used->insert(this);
      return MassAndWall::step(state, step);
    }
  };
  MassPhysics physics;
  CopyMethod method(Noting{&used});
  for (int ms = 0; ms <= 30; ++ms) {
    method.sample(ms);
    if (ms == 20) method.give(10, ms, physics.go_to(10));
    method.tick(ms);
  }
  BOOST_TEST(used.size() == 2U);
}

BOOST_AUTO_TEST_CASE(a_copy_that_throws_or_is_not_finite_is_a_fault_of_its_node) {
  const auto check = [](const CopyFunction& step, const std::string& why) {
    MassPhysics physics;
    const EngineState result = physics.go_to(10);
    CopyMethod method(step);
    for (int ms = 0; ms <= 11; ++ms) method.sample(ms);
    BOOST_CHECK_EXCEPTION(method.give(10, 11, result), RunError,
                          says("the program's light copy failed in its step from 0.010000 s: " + why));
    method.give_to_rollout(11, result);
    BOOST_CHECK_EXCEPTION(method.tick(11), RunError, says(why));
  };
  check([](std::span<double>, const CopyStep&) -> CopyTool { throw std::runtime_error("out of range"); },
        "out of range");
  check([](std::span<double>, const CopyStep&) -> CopyTool { throw 42; },
        "it threw something that is no std::exception");
  check(
      [](std::span<double> state, const CopyStep& step) {
        CopyTool tool = MassAndWall::step(state, step);
        tool.X_WT.p.z = std::nan("");
        return tool;
      },
      "the tool's pose or velocity is not finite");
  check(
      [](std::span<double> state, const CopyStep& step) {
        const CopyTool tool = MassAndWall::step(state, step);
        state[4] = std::nan("");
        return tool;
      },
      "a number of its state is not finite");
}

BOOST_AUTO_TEST_CASE(a_node_without_a_copy_and_a_state_of_another_size_are_refused) {
  MassPhysics physics;
  const EngineState result = physics.go_to(10);
  CopyMethod without(CopyFunction{});
  BOOST_TEST(!without.tick(9));
  for (int ms = 0; ms <= 10; ++ms) without.sample(ms);
  BOOST_CHECK_EXCEPTION(without.give(10, 10, result), RunError, says("no program has given its light copy"));
  without.give_to_rollout(10, result);
  BOOST_CHECK_EXCEPTION(without.tick(10), RunError, says("no program has given its light copy"));
  EngineState other = result;
  other.identity = 5;
  CopyMethod method;
  for (int ms = 0; ms <= 10; ++ms) method.sample(ms);
  method.give(10, 10, other);
  BOOST_TEST(method.metric("prediction.rejected_results") == 1.0);
  method.give_to_rollout(10, other);
  BOOST_TEST(!method.tick(10));
  BOOST_TEST(method.metric("rollout.rejected_models") == 1.0);
}

BOOST_AUTO_TEST_CASE(the_rollout_of_a_copy_allocates_nothing, *boost::unit_test::precondition(heap_is_counted)) {
  MassPhysics physics;
  CopyMethod method;
  const EngineState first = physics.go_to(100), second = physics.go_to(110);
  for (int ms = 90; ms < 120; ++ms) {
    method.sample(ms);
    if (ms == 101) method.give(100, ms, first);
    method.tick(ms);
  }
  std::int64_t calls = 0;
  bool shown = true;
  for (int ms = 120; ms < 160; ++ms) {
    method.sample(ms);
    if (ms == 121) method.give(110, ms, second);
    const std::int64_t before = thread_heap_calls();
    shown = method.tick(ms) && shown;
    calls += thread_heap_calls() - before;
  }
  BOOST_TEST(calls == 0);
  BOOST_TEST(shown);
}

BOOST_AUTO_TEST_SUITE_END()
