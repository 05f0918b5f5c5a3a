// The node of the wave line: what it sends, refuses, and leaves to the heap.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <deque>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/passivity/waves.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(waves_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr Duration tick{1'000'000};
constexpr double T = 1e-3;  // s

/// A line with a device that commands what it sends, and a tool that stands at the origin.
struct Loop {
  explicit Loop(const NodeContext& c = context(false)) : waves(default_params<Waves>(), c) {
    waves.device.configure({QueuePolicy::drop_oldest, 64});
    waves.commanded.configure({QueuePolicy::drop_oldest, 64});
    waves.state.configure({QueuePolicy::latest, 1});
  }
  /// The device shows the handle and commands the force that was sent; then the line steps, `steps` or not.
  void device_tick(const Vec3& p, const Vec3& v, bool steps = true) {
    DeviceState state;
    state.X_WD.p = p;
    state.V_WD.v = v;
    commanded = evaluate(shown, now);
    const Stamp stamp{now, now, n++};
    waves.device.push(stamp, &state);
    waves.commanded.push(stamp, &commanded);
    sent = 0;
    if (steps) step();
    now = now + tick;
  }
  /// A tick of both in lanes of their own: neither hears in it what the other sends.
  void tick_of_both(const Vec3& p, const Vec3& v) {
    const ForceSegment before = shown;
    step();
    const ForceSegment later = std::exchange(shown, before);
    device_tick(p, v, false);
    shown = later;
  }
  void result() { result_of(wave_at, wave.X_WD.p, {}); }
  void result_of(Time at, const Vec3& p_WD, const Vec3& p_WT) {
    PhysicsState state;
    state.X_WD.p = p_WD;
    state.X_WT.p = p_WT;
    const Stamp stamp{at, now, n};
    waves.state.push(stamp, &state);
  }
  void step() {
    StepContext c(now);
    waves.step(c);
    sent = waves.wave.pending();
    if (sent > 0) {
      wave = test::sent(waves.wave, sent - 1);
      wave_at = waves.wave.pending_valid(sent - 1);
    }
    if (waves.segment.pending() > 0) {
      shown = test::sent(waves.segment);
      valid = waves.segment.pending_valid(0);
    }
    if (waves.force.pending() > 0) force = test::sent(waves.force).force;
    waves.wave.clear_pending();
    waves.segment.clear_pending();
    waves.force.clear_pending();
  }
  Waves waves;
  Time now;
  std::uint64_t n = 0;
  DeviceState wave;
  Time wave_at, valid;
  ForceSegment shown;
  Wrench commanded;
  Vec3 force;
  std::size_t sent = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(the_tool_is_dragged_by_a_damper_of_the_impedance) {
  Loop loop;
  StepContext c({});
  loop.waves.start(c);
  const CouplingParameters& parameters = sent(loop.waves.parameters);
  BOOST_TEST(parameters.k_t == 0);
  BOOST_TEST(parameters.b_t == default_params<Waves>().impedance);
  BOOST_TEST(parameters.massless == 0);
}

BOOST_AUTO_TEST_CASE(the_wave_that_leaves_is_of_the_force_commanded_and_of_the_way_shown) {
  const double b = default_params<Waves>().impedance;
  Dice draw(4);
  Loop loop;
  Vec3 p, place;
  for (int i = 0; i < 300; ++i) {
    const Vec3 way = draw.normal_vector(1e-4);
    const Vec3 force = loop.commanded.force;
    p += way;
    place += i > 0 ? way - (T / b) * force : way;
    const Vec3 before = loop.wave.X_WD.p;
    loop.device_tick(p, (1 / T) * way);
    BOOST_TEST_REQUIRE(loop.sent == 1U);
    BOOST_TEST(norm(loop.wave.X_WD.p - place) < 1e-12);
    if (i > 0) BOOST_TEST(norm(T * loop.wave.V_WD.v - (place - before)) < 1e-12);
    BOOST_TEST((loop.wave_at == loop.now + Duration{-tick.ns}));
    if (i % 12 == 0) loop.result();
  }
  BOOST_TEST(norm(loop.commanded.force) > 0.1, "a force was there");
}

BOOST_AUTO_TEST_CASE(a_force_is_stamped_as_the_result_that_it_comes_from_and_none_is_sent_before) {
  const double b = default_params<Waves>().impedance;
  Loop loop;
  for (int i = 0; i < 20; ++i) loop.device_tick({1e-4 * i, 0, 0}, {0.1, 0, 0});
  BOOST_TEST((loop.shown.begin == Time{}), "nothing has come from physics");
  loop.result();
  const Time made = loop.wave_at;
  for (int i = 20; i < 30; ++i) {
    loop.device_tick({1e-4 * i, 0, 0}, {0.1, 0, 0});
    BOOST_TEST((loop.valid == made));
    BOOST_TEST((loop.shown.begin == loop.now));
  }
  // No force acted, so that the far end went with 0.1 m/s past a tool that stood.
  BOOST_TEST(std::abs(loop.force.x + 0.1 * b) < 1e-9);
}

BOOST_AUTO_TEST_CASE(in_lanes_the_force_is_that_of_the_tick_at_which_the_device_commands_it) {
  Loop one, lanes;
  double largest = 0;
  for (int i = 0; i < 200; ++i) {
    // The hand pushes the handle against 1 N, and then holds it. From then on all is foreseen, so that a line that
    // hears a tick later, and acts a tick later, commands the same forces at the same ticks.
    const Vec3 p{-2e-3 * std::min(i, 20) / 20, 0, 0};
    const Vec3 v{i > 0 && i <= 20 ? -0.1 : 0, 0, 0};
    if (i < 22) one.shown = lanes.shown = constant_segment({}, {{i < 20 ? 1.0 : 0.0, 0, 0}, {}});
    one.device_tick(p, v);
    lanes.tick_of_both(p, v);
    BOOST_TEST(norm(one.commanded.force - lanes.commanded.force) < 1e-12, i);
    if (i > 25) largest = std::max(largest, norm(lanes.commanded.force));
    if (i < 25 || i % 12 != 0) continue;
    for (Loop* loop : {&one, &lanes}) loop->result_of(Time{} + tick * (i - 4), {-2e-3 - 1e-6 * i, 0, 0}, {});
  }
  BOOST_TEST(largest > 0.5);
}

BOOST_AUTO_TEST_CASE(after_sixteen_ticks_without_a_sample_nothing_is_commanded) {
  Loop loop;
  for (int i = 0; i <= 40; ++i) {
    if (i < 40) loop.shown = constant_segment({}, {{1, 0, 0}, {}});
    if (i == 40) loop.result_of(loop.wave_at, loop.wave.X_WD.p, {});
    loop.device_tick({-1e-4 * i, 0, 0}, {-0.1, 0, 0});
  }
  // The line steps on at the ticks of a device that shows nothing any more.
  for (int i = 1; i <= 16; ++i) {
    loop.step();
    const Time acts = loop.now + tick;
    if (i < 15) {
      BOOST_TEST((loop.shown.begin == acts));
      BOOST_TEST(norm(evaluate(loop.shown, acts).force) > 0.1);
    } else {
      BOOST_TEST(norm(evaluate(loop.shown, acts).force) == 0);
    }
    loop.now = loop.now + tick;
  }
}

BOOST_AUTO_TEST_CASE(a_tool_is_as_heavy_as_it_is_and_gives_nothing_by_sagging) {
  for (const double mass : {0.05, 0.2, 0.5}) {
    for (const int delay : {10, 50, 100}) {
      Scene scene;
      Body body;
      body.name = scene.tool_name = "tool";
      body.motion = Motion::translation;
      body.mass = mass;
      scene.bodies.push_back(body);
      NodeContext with_weight = context(false);
      with_weight.scene = &scene;
      Loop loop(with_weight);
      const double w = mass * scene.gravity_W.z, b = default_params<Waves>().impedance, stays = std::exp(-b * T / mass);
      BOOST_REQUIRE(w < 0);
      std::deque<std::pair<Time, PhysicsState>> under_way;
      PhysicsState far;
      double net = 0, most = 0, of_a_tick = 0, before = 0;
      for (int n = 0; n < 12000; ++n) {
        // A hand that stands, and then goes up and down, ever faster.
        const double t = n * T - 4, z = t > 0 ? 0.03 * std::sin(t * (1 + t)) : 0, way = z - before;
        before = z;
        if (loop.commanded.force.z != 0) net += (loop.commanded.force.z - w) * way;
        most = std::max(most, net);
        of_a_tick = std::max(of_a_tick, std::abs(loop.commanded.force.z * way));
        loop.device_tick({0, 0, z}, {0, 0, way / T});
        // The tool on the damper, exact with the wave steady in the tick.
        const double rest = (loop.wave.X_WD.p.z - far.X_WD.p.z) / T + w / b, v = far.V_WT.v.z;
        far.X_WT.p.z += rest * T + (v - rest) * (1 - stays) * mass / b;
        far.V_WT.v.z = rest + (v - rest) * stays;
        far.X_WD = loop.wave.X_WD;
        if (n % 10 == 0) under_way.emplace_back(loop.wave_at, far);
        if (!under_way.empty() && loop.now >= under_way.front().first + tick * delay) {
          loop.result_of(under_way.front().first, under_way.front().second.X_WD.p, under_way.front().second.X_WT.p);
          under_way.pop_front();
        }
        if (n == 3999) BOOST_TEST(std::abs(loop.commanded.force.z - w) < -1e-3 * w, mass << " kg, " << delay << " ms");
      }
      BOOST_TEST(std::abs(far.X_WT.p.z) < 0.2, "the tool is about where the handle is");
      BOOST_TEST(of_a_tick > 0);
      BOOST_TEST(most <= of_a_tick, mass << " kg, " << delay << " ms: " << most << " J of " << of_a_tick);
    }
  }
}

BOOST_AUTO_TEST_CASE(of_several_samples_at_once_one_wave_leaves_and_nothing_is_lost) {
  Loop one, several;
  for (int i = 0; i < 40; ++i) {
    const Vec3 p{1e-6 * i * i, 0, 0};
    one.device_tick(p, {});
    several.device_tick(p, {}, i % 10 == 9);
    if (several.sent == 0) continue;
    BOOST_TEST(several.sent == 1U);
    BOOST_TEST(norm(one.wave.X_WD.p - several.wave.X_WD.p) < 1e-15);
    BOOST_TEST((one.wave_at == several.wave_at));
  }
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_is_left_out) {
  Loop loop;
  const double nan = std::nan("");
  for (int i = 0; i < 100; ++i) {
    loop.device_tick({i == 50 ? nan : 0.0, 0, 0}, {});
    BOOST_TEST(is_finite(loop.wave.X_WD.p));
    BOOST_TEST(is_finite(evaluate(loop.shown, loop.now)));
    if (i % 12 != 0) continue;
    PhysicsState state;
    if (i == 60) state.X_WT.p.y = nan;
    const Stamp stamp{loop.wave_at, loop.now, loop.n};
    loop.waves.state.push(stamp, &state);
  }
}

BOOST_AUTO_TEST_CASE(a_scene_with_torques_is_refused) {
  try {
    Waves waves(default_params<Waves>(), context(true));
    BOOST_ERROR("it was taken");
  } catch (const InputError& e) {
    BOOST_TEST(std::string(e.what()).find("no torques") != std::string::npos, e.what());
  }
}

BOOST_AUTO_TEST_CASE(an_impedance_that_the_handle_cannot_bear_is_refused) {
  Waves::Params params = default_params<Waves>();
  params.impedance = 0.25 * params.mass * params.rate;
  BOOST_CHECK_NO_THROW(Waves(params, context(false)));
  params.impedance *= 1.01;
  BOOST_CHECK_THROW(Waves(params, context(false)), InputError);
}

BOOST_AUTO_TEST_CASE(no_step_of_the_line_calls_the_heap,
                     *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  Dice draw(3);
  Loop loop;
  std::int64_t before = 0;
  Vec3 p;
  for (int i = 0; i < 6000; ++i) {
    if (i == 100) before = thread_heap_calls();
    const Vec3 v = draw.normal_vector(0.1);
    p += T * v;
    loop.device_tick(p, v, i % 20 != 0);
    if (i % 12 == 0 && loop.sent > 0) loop.result();
  }
  BOOST_TEST(thread_heap_calls() - before == 0);
}

BOOST_AUTO_TEST_SUITE_END()
