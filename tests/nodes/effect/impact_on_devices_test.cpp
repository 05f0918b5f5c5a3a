// effect.impact on the devices of graphs/devices: the handle's acceleration against the wanted one, by the device's
// truth.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "devices/simulated/simulated.hpp"
#include "framework/core/segment.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/spec.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/registry.hpp"
#include "nodes/effect/impact.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(impact_on_devices_test)

using namespace tactor;

namespace {

/// Leads the hand and makes the force; never stepped.
struct Lab final : Node {
  struct Params {};
  Lab(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Lab>("test.lab", "A hand and a force.")
        .output("target", &Lab::target, "")
        .output("segment", &Lab::segment, "")
        .info();
  }
  void step(StepContext&) override {}
  Output<Target> target;
  Output<ForceSegment> segment;
};

struct Run {
  std::vector<double> acceleration;  // m/s^2, of the handle along z, mean over each tick
  double impact_speed = 0;           // m/s, as the device showed it when the force began
  std::map<std::string, double> metrics;
};

constexpr double T = 1e-3;
constexpr int contact = 600, ticks = 800;

/// A hand that moves down at 0.2 m/s; from tick `contact` on a force of 0.3 N, whatever the handle does.
Run run(const std::string& preset, const std::string& impact) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "graph.yaml";
  std::ofstream(file) << "format: 2\ntitle: an impact\nclock: virtual\nduration: 1 s\nseed: 1\n"
                         "scene:\n  bodies:\n    tool: {sphere: {radius: 4 mm}, motion: translation, mass: 50 g}\n"
                         "nodes:\n  lab: {type: test.lab}\n"
                         "  device: {type: device.simulated, loop: closed, engage_time: 1 ms, force_slew: 1e4}\n"
                         "  impact: {type: effect.impact, "
                      << impact
                      << "}\nedges:\n  - lab.target -> device.target\n  - lab.segment -> impact.segment\n"
                         "  - device.state -> impact.device\n  - impact.segment -> device.segment\n";
  Registry registry{{}};
  registry.add<SimulatedDevice>();
  registry.add<Lab>();
  registry.add<Impact>();
  const std::filesystem::path over = std::filesystem::path(TACTOR_SOURCE_DIR) / "graphs/devices" / (preset + ".yaml");
  const GraphSpec spec = load_graph(file, registry, {over_patch(over)});
  NodeContext context;
  context.name = "node";
  context.scene = &spec.scene;
  context.torque = false;
  context.duration = Duration{1'000'000'000};
  std::unique_ptr<Node> device_node, impact_node;
  for (const NodeSpec& node : spec.nodes) {
    if (node.name == "device") device_node = node.info->create(node.params, context);
    if (node.name == "impact") impact_node = node.info->create(node.params, context);
  }
  auto& device = dynamic_cast<SimulatedDevice&>(*device_node);
  auto& stage = dynamic_cast<Impact&>(*impact_node);
  device.target.configure({QueuePolicy::latest, 1});
  device.segment.configure({QueuePolicy::latest, 1});
  stage.base.configure({QueuePolicy::latest, 1});
  stage.device.configure({QueuePolicy::latest, 1});

  Run result;
  std::vector<double> v;
  std::uint64_t sequence = 0;
  for (int n = 0; n < ticks; ++n) {
    const Time now{n * 1'000'000};
    const Stamp stamp{now, now, static_cast<std::uint64_t>(n)};
    Target target;
    target.X_WH.p = {0, 0, -0.2 * n * T};
    target.V_WH.v = {0, 0, -0.2};
    device.target.push(stamp, &target);
    StepContext step(now);
    device.step(step);
    v.push_back(static_cast<const DeviceState*>(device.truth.pending_value(0))->V_WD.v.z);
    const auto& shown = *static_cast<const DeviceState*>(device.state.pending_value(0));
    if (n == contact) result.impact_speed = -shown.V_WD.v.z;
    stage.device.push(stamp, &shown);
    for (OutputBase* out : {static_cast<OutputBase*>(&device.truth), static_cast<OutputBase*>(&device.state),
                            static_cast<OutputBase*>(&device.motors), static_cast<OutputBase*>(&device.commanded),
                            static_cast<OutputBase*>(&device.interpolated), static_cast<OutputBase*>(&device.safety)}) {
      out->clear_pending();
    }
    const ForceSegment force = constant_segment(now, {{0, 0, n >= contact ? 0.3 : 0}, {}});
    stage.base.push(stamp, &force);
    stage.step(step);
    if (stage.segment.pending() > 0) {
      device.segment.push({now, now, sequence++}, stage.segment.pending_value(0));
      stage.segment.clear_pending();
    }
  }
  for (std::size_t n = 0; n + 1 < v.size(); ++n) result.acceleration.push_back((v[n + 1] - v[n]) / T);
  result.metrics = test::metrics_of(stage);
  return result;
}

struct Miss {
  double rms = 0, most = 0;  // of the wanted RMS, and of the wanted peak
};

/// What the handle's acceleration misses, beside that of the same run without a vibration.
Miss miss(const std::string& preset, double frequency, double decay, double amplitude, int delay_ticks) {
  const std::string shape = "frequency: " + std::to_string(frequency) + " Hz, decay: " + std::to_string(decay) + " s";
  const Run with = run(preset, shape + ", amplitude: " + std::to_string(amplitude));
  const Run without = run(preset, shape + ", amplitude: 0");
  BOOST_TEST(with.metrics.at("impact.events") == 1.0);
  BOOST_TEST(with.metrics.at("impact.limited_events") == 0.0);
  const auto n = static_cast<std::size_t>(5 * decay / T);
  const std::vector<double> wanted = decaying_sinusoid(amplitude * with.impact_speed, frequency, decay, T, n);
  double squares = 0, missed = 0, peak = 0, most = 0;
  for (std::size_t k = 0; k < n; ++k) {
    // The force of a curve that comes at a tick is shown at the next.
    const std::size_t tick = contact + 1 + static_cast<std::size_t>(delay_ticks) + k;
    const double error = with.acceleration[tick] - without.acceleration[tick] - wanted[k];
    squares += wanted[k] * wanted[k];
    missed += error * error;
    peak = std::max(peak, std::abs(wanted[k]));
    most = std::max(most, std::abs(error));
  }
  return {std::sqrt(missed / squares), most / peak};
}

}  // namespace

BOOST_AUTO_TEST_CASE(on_an_ideal_device_it_is_the_wanted_acceleration) {
  for (const double frequency : {30.0, 100.0, 200.0}) {
    const Miss m = miss("ideal", frequency, 0.01, 10, 0);
    BOOST_TEST_MESSAGE("ideal " << frequency << " Hz: " << m.rms << " RMS, " << m.most << " most");
    BOOST_TEST(m.rms < 0.02);
    BOOST_TEST(m.most < 0.02);
  }
}

BOOST_AUTO_TEST_CASE(on_devices_with_amplifier_and_mode_it_is_within_a_tenth) {
  const std::vector<std::pair<std::string, int>> presets{{"omega_3", 0}, {"phantom_premium_1_5", 0}, {"touch", 1}};
  for (const auto& [preset, delay] : presets) {
    const Miss slow = miss(preset, 30, 0.015, 1, delay), fast = miss(preset, 60, 0.01, 0.8, delay);
    BOOST_TEST_MESSAGE(preset << " 30 Hz: " << slow.rms << " RMS, " << slow.most << " most; 60 Hz: " << fast.rms
                              << " RMS, " << fast.most << " most");
    BOOST_TEST(slow.rms < 0.1);
    BOOST_TEST(slow.most < 0.1);
    BOOST_TEST(fast.rms < 0.1);
  }
}

BOOST_AUTO_TEST_SUITE_END()
