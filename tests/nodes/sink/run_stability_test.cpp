// Stability of runs whose energy at the handle and motion at rest are known in closed form.
#include "nodes/sink/run_stability.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "nodes/sink/metrics.hpp"
#include "nodes/sink/port_passivity.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(run_stability_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double k = 500;     // N/m
constexpr double A = 0.01;    // m
constexpr double w = 2 * pi;  // rad/s
constexpr int run_ms = 4250;

/// A handle that goes A sin(w t) against the force -k x(t - d) - b v(t), commanded every millisecond.
struct DelayedSpring {
  std::vector<Stamped<Wrench>> commanded;
  std::vector<HandleSample> handle;

  DelayedSpring(double d, double b) {
    for (int ms = 0; ms <= run_ms; ++ms) {
      const double t = 1e-3 * ms;
      const double force = -k * A * std::sin(w * (t - d)) - b * A * w * std::cos(w * t);
      commanded.push_back({stamp_ms(ms), Wrench{{force, 0, 0}, {}}});
      handle.push_back({stamp_ms(ms).valid, Pose{{A * std::sin(w * t), 0, 0}, {}}});
    }
  }
  [[nodiscard]] RunSignals signals() const { return {.commanded = commanded, .handle = handle, .tool = {}}; }
};

/// J, the most that the delayed spring has given by any time: the integral of its force times the velocity.
double most_given_back(double d) {
  double most = 0;
  for (int ms = 0; ms <= run_ms; ++ms) {
    const double t = 1e-3 * ms;
    const double given =
        0.5 * k * A * A * (w * t * std::sin(w * d) + 0.5 * (std::cos(2 * w * t - w * d) - std::cos(w * d)));
    most = std::max(most, given);
  }
  return most;
}

/// A tool that swings with `amplitude` (m) at `hz` through the whole run.
std::vector<ToolSample> swinging(double amplitude, double hz, double step_ms) {
  std::vector<ToolSample> tool;
  for (double ms = 0; ms <= run_ms; ms += step_ms) {
    const double phase = 2 * pi * hz * 1e-3 * ms;
    tool.push_back(
        {stamp_ms(ms).valid, {0, amplitude * std::sin(phase), 0}, {0, amplitude * 2 * pi * hz * std::cos(phase), 0}});
  }
  return tool;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_spring_that_comes_late_gives_the_hand_energy_by_the_closed_form) {
  for (const double d : {0.01, 0.04}) {
    // A command that is held for a tick comes half a tick later still.
    const DelayedSpring spring(d, 0);
    const auto f = run_stability(spring.signals(), {}, 1e-4);
    BOOST_TEST_REQUIRE(f.has_value());
    const double expected = most_given_back(d + 0.5e-3);
    BOOST_TEST(std::abs(f->generated_J - expected) < 2e-3 * expected, f->generated_J << " " << expected);
    BOOST_TEST(name_of(f->verdict) == "energy");
    BOOST_TEST(f->peak_to_peak_m == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(a_damper_takes_what_a_late_spring_makes) {
  // The spring makes k A^2 pi sin(w d) a period, the damper takes b A^2 pi w: they balance at b = k sin(w d) / w.
  const double d = 0.01;
  const double balance = k * std::sin(w * (d + 0.5e-3)) / w;
  const auto more = run_stability(DelayedSpring(d, 2 * balance).signals(), {}, 1e-4);
  BOOST_TEST(name_of(more->verdict) == "stable");
  BOOST_TEST(more->generated_J < 1e-6);
  const auto less = run_stability(DelayedSpring(d, 0.5 * balance).signals(), {}, 1e-4);
  BOOST_TEST(less->generated_J > 0.01);
}

BOOST_AUTO_TEST_CASE(a_tool_that_swings_at_rest_is_told_with_amplitude_and_frequency) {
  const std::vector<ToolSample> tool = swinging(1e-3, 12, 10);
  const RunSignals signals{.commanded = {}, .handle = {}, .tool = tool, .mass = 0.2};
  const auto f = run_stability(signals, Duration::from_seconds(1), 1e-4);
  BOOST_TEST_REQUIRE(f.has_value());
  BOOST_TEST(name_of(f->verdict) == "limit_cycle");
  // Physics every 10 ms may miss a peak by half of that.
  BOOST_TEST(f->amplitude_m <= 1e-3);
  BOOST_TEST(f->amplitude_m >= 1e-3 * std::cos(pi * 12 * 0.01));
  BOOST_TEST(std::abs(f->frequency_Hz - 12) < 0.1);
  // Kinetic energy m v^2 / 2 at the middle of the swing, where the run begins.
  const double peak = 0.5 * 0.2 * std::pow(1e-3 * 2 * pi * 12, 2);
  BOOST_TEST(std::abs(f->peak_energy_J - peak) < 1e-9);
  BOOST_TEST(name_of(run_stability(signals, {}, 1e-4)->verdict) == "stable");
  BOOST_TEST(name_of(run_stability(signals, Duration::from_seconds(1), 3e-3)->verdict) == "stable");
}

BOOST_AUTO_TEST_CASE(a_weight_that_is_let_down_and_lifted_makes_no_energy) {
  // The hand carries the weight of the tool all the way, down and up by 50 mm.
  const double mass = 0.3, g = 9.81;
  std::vector<Stamped<Wrench>> commanded;
  std::vector<HandleSample> handle;
  std::vector<ToolSample> tool;
  for (int ms = 0; ms <= 2000; ++ms) {
    const double z = -0.05 * std::sin(pi * 1e-3 * ms);
    commanded.push_back({stamp_ms(ms), Wrench{{0, 0, -mass * g}, {}}});
    handle.push_back({stamp_ms(ms).valid, Pose{{0, 0, z}, {}}});
    tool.push_back({stamp_ms(ms).valid, {0, 0, z}, {}});
  }
  const auto f = run_stability({commanded, handle, tool, mass, {0, 0, -g}}, {}, 1e-4);
  BOOST_TEST(name_of(f->verdict) == "stable");
  BOOST_TEST(f->generated_J < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_tool_below_its_start_has_the_energy_of_its_motion) {
  // z = -A (1 - cos w t): all the way below the start, where the weight is worth far less than nothing.
  const double mass = 0.3, g = 9.81, A = 0.025, rate = 2 * pi;
  std::vector<ToolSample> tool, turned;
  for (int ms = 0; ms <= 1000; ++ms) {
    const double z = A * (1 - std::cos(rate * 1e-3 * ms)), v = A * rate * std::sin(rate * 1e-3 * ms);
    tool.push_back({stamp_ms(ms).valid, {0, 0, -z}, {0, 0, -v}});
    turned.push_back({stamp_ms(ms).valid, {0, 0, z}, {0, 0, v}});
  }
  const double fastest = 0.5 * mass * std::pow(A * rate, 2);
  const auto below = run_stability({{}, {}, tool, mass, {0, 0, -g}}, {}, 1e-4);
  BOOST_TEST(std::abs(below->peak_energy_J - fastest) < 1e-9);
  // Above the start height counts too; as it is worth so much more here, the most is where the tool turns back, at
  // rest.
  const auto above = run_stability({{}, {}, turned, mass, {0, 0, -g}}, {}, 1e-4);
  BOOST_TEST(std::abs(above->peak_energy_J - mass * g * 2 * A) < 1e-9);
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_is_told) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  DelayedSpring spring(0, 0);
  spring.commanded[100].value.force.y = nan;
  BOOST_TEST(name_of(run_stability(spring.signals(), {}, 1e-4)->verdict) == "not_finite");
  std::vector<ToolSample> tool = swinging(1e-3, 5, 10);
  tool.back().v_WT.x = nan;
  const RunSignals signals{.commanded = {}, .handle = {}, .tool = tool, .mass = 1};
  BOOST_TEST(name_of(run_stability(signals, {}, 1e-4)->verdict) == "not_finite");
  BOOST_TEST(!run_stability({}, {}, 1e-4).has_value());
}

BOOST_AUTO_TEST_CASE(the_sink_tells_it_with_figures) {
  Metrics::Params params;
  params.rest = Duration::from_seconds(1);
  params.rest_peak_to_peak = 1e-4;
  NodeContext sink_context = context();
  sink_context.duration = Duration::from_seconds(4.25);
  Metrics sink(params, sink_context);
  const Queue queue{QueuePolicy::drop_oldest, 64};
  for (InputBase* input : {static_cast<InputBase*>(&sink.commanded), static_cast<InputBase*>(&sink.force),
                           static_cast<InputBase*>(&sink.state), static_cast<InputBase*>(&sink.device)}) {
    input->configure(queue);
  }
  const DelayedSpring spring(0.01, 0);
  for (std::size_t ms = 0; ms < spring.handle.size(); ++ms) {
    const Stamp now = stamp_ms(static_cast<double>(ms), ms);
    DeviceState device;
    device.X_WD = spring.handle[ms].X_WD;
    sink.commanded.push(now, &spring.commanded[ms].value);
    sink.device.push(now, &device);
    if (ms % 10 == 0) {
      PhysicsState state;
      state.X_WT.p.z = 1e-3 * std::sin(2 * pi * 8 * 1e-3 * static_cast<double>(ms));
      sink.state.push(now, &state);
    }
    StepContext c(now.produced);
    sink.step(c);
  }
  const auto f = metrics_of(sink);
  const double expected = most_given_back(0.0105);
  BOOST_TEST(f.at("stability.verdict") == 3.0);
  BOOST_TEST(std::abs(f.at("stability.passivity_violation_J") - expected) < 2e-3 * expected);
  BOOST_TEST(std::abs(f.at("stability.oscillation_frequency_Hz") - 8) < 0.1);
  BOOST_TEST(std::abs(f.at("stability.oscillation_amplitude_m") - 1e-3) < 5e-5);
  BOOST_TEST(f.contains("stability.peak_energy_J"));
  params.rest = Duration::from_seconds(5);
  BOOST_CHECK_EXCEPTION(Metrics(params, sink_context), InputError, [](const InputError& e) {
    return std::string(e.what()).starts_with("rest: expected at most");
  });
}

BOOST_AUTO_TEST_CASE(a_sampled_spring_gives_half_its_stiffness_times_each_step_squared_and_may_give_a_tick) {
  // Held forces -k x(n) along x = A sin(w t): over a whole period k/2 times the sum of the squared steps.
  const DelayedSpring spring(0, 0);
  const double tick = 1e-3, step = 2 * A * std::sin(0.5 * w * tick);
  RunSignals signals = spring.signals();
  signals.handle = signals.handle.first(1001);
  const auto found = port_passivity(signals, 1e-5, 1e-4);
  BOOST_REQUIRE(found.has_value());
  // At the end of the period nothing is stored, and at no time before had more been given.
  BOOST_TEST(std::abs(found->generated_J - 0.5 * k * 1000 * 0.5 * step * step) < 1e-12);
  // k A^2 sin(a) 2 sin(h) cos(a + h) of a tick, h = w T / 2: the most is k A^2 sin(h) (1 + sin(h)).
  const double h = std::sin(0.5 * w * tick);
  const double allowed = k * A * 1e-5 + k * A * A * h * (1 + h);
  BOOST_TEST(std::abs(found->allowed_J - allowed) < 1e-4 * allowed);
  // 0.49 mJ of 0.21 mJ.
  BOOST_TEST(!found->passive());
  // A damper of more than k T / 2 takes what the hold gives.
  const DelayedSpring damped(0, 0.6 * k * tick);
  BOOST_TEST(port_passivity(damped.signals(), 1e-5, 1e-4)->passive());
  BOOST_TEST(!port_passivity({}, 1e-5, 1e-4).has_value());
}

BOOST_AUTO_TEST_CASE(the_weight_of_a_tool_is_no_energy_of_the_port) {
  const Vec3 gravity{0, 0, -9.81};
  std::vector<Stamped<Wrench>> commanded;
  std::vector<HandleSample> handle;
  for (int ms = 0; ms <= 1000; ++ms) {
    commanded.push_back({stamp_ms(ms), Wrench{0.1 * gravity, {}}});
    handle.push_back({stamp_ms(ms).valid, Pose{{0, 0, -1e-4 * ms}, {}}});
  }
  RunSignals signals{.commanded = commanded, .handle = handle, .tool = {}, .mass = 0.1, .gravity_W = gravity};
  BOOST_TEST(port_passivity(signals, 0, 0)->generated_J < 1e-15);
  // The same force without a weight: 0.981 N over 0.1 m.
  signals.gravity_W = {};
  BOOST_TEST(std::abs(port_passivity(signals, 0, 0)->generated_J - 0.0981) < 1e-12);
  commanded[500].value.force.x = std::numeric_limits<double>::quiet_NaN();
  BOOST_TEST(!port_passivity(signals, 0, 0)->passive());
}

BOOST_AUTO_TEST_SUITE_END()
