// The devices of graphs/devices can be laid over a graph, and what they lay is a device that can be.
#include <boost/test/unit_test.hpp>
#include <filesystem>
#include <fstream>
#include <set>

#include "devices/simulated/simulated.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/spec.hpp"
#include "framework/node/declare.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(presets_test)

using namespace tactor;

namespace {

/// Leads the hand; never stepped.
struct Hand final : Node {
  struct Params {};
  Hand(const Params&, const NodeContext&) {}
  static NodeInfo declare() { return Declare<Hand>("test.hand", "A hand.").output("target", &Hand::target, "").info(); }
  void step(StepContext&) override {}
  Output<Target> target;
};

const std::filesystem::path folder = std::filesystem::path(TACTOR_SOURCE_DIR) / "graphs" / "devices";

/// The parameters of the device of a small graph with that file over it.
SimulatedDevice::Params with_over(const std::string& file, const std::string& device = "") {
  TemporaryFolder temporary;
  const std::filesystem::path graph = temporary.path() / "graph.yaml";
  std::ofstream(graph) << "format: 2\ntitle: a hand on a device\nclock: virtual\nduration: 1 s\nseed: 1\n"
                          "scene:\n  bodies:\n    tool: {sphere: {radius: 4 mm}, motion: rigid, mass: 50 g}\n"
                          "nodes:\n  hand: {type: test.hand}\n  device: {type: device.simulated"
                       << device << "}\nedges:\n  - hand.target -> device.target\n";
  Registry registry{{}};
  registry.add<SimulatedDevice>();
  registry.add<Hand>();
  Overrides overrides;
  if (!file.empty()) overrides.push_back(over_patch(folder / file));
  const GraphSpec spec = load_graph(graph, registry, overrides);
  for (const NodeSpec& node : spec.nodes) {
    if (node.name != "device") continue;
    SimulatedDevice::Params params{};
    for (std::size_t i = 0; i < node.params.size(); ++i) node.info->params[i].assign(&params, node.params[i]);
    NodeContext context;
    context.name = "device";
    context.scene = &spec.scene;
    context.duration = Duration{1'000'000'000};
    SimulatedDevice(params, context);  // which refuses what cannot be
    return params;
  }
  throw RunError("no device");
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_device_can_be_laid_over_a_graph) {
  std::set<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".yaml") continue;
    found.insert(entry.path().stem().string());
    BOOST_TEST_CONTEXT(entry.path()) {
      BOOST_CHECK_NO_THROW(with_over(entry.path().filename().string()));
    }
  }
  for (const char* name : {"ideal", "phantom_premium_1_5", "touch", "omega_3"}) BOOST_TEST(found.count(name) == 1U);
}

BOOST_AUTO_TEST_CASE(the_ideal_device_is_the_default_and_switches_every_part_off) {
  const SimulatedDevice::Params plain = with_over("");
  for (const char* given : {"",
                            ", amplifier_bandwidth: 100 Hz, mode_frequency: 50 Hz, backlash: 1 mm, breakaway: 1 N, "
                            "cogging: 0.1 N, delay_in: 1 ms, delay_out: 1 ms, encoder_noise: 1 um, "
                            "encoder_noise_angle: 0.001 rad, motor_force_max: 1 N, motor_torque_max: 0.1 N m"}) {
    const SimulatedDevice::Params ideal = with_over("ideal.yaml", given);
    BOOST_TEST(ideal.amplifier_bandwidth == plain.amplifier_bandwidth);
    BOOST_TEST(ideal.motor_force_max == plain.motor_force_max);
    BOOST_TEST(ideal.motor_torque_max == plain.motor_torque_max);
    BOOST_TEST(ideal.cogging == plain.cogging);
    BOOST_TEST(ideal.breakaway == plain.breakaway);
    BOOST_TEST(ideal.mode_frequency == plain.mode_frequency);
    BOOST_TEST(ideal.backlash == plain.backlash);
    BOOST_TEST(ideal.encoder_noise == plain.encoder_noise);
    BOOST_TEST(ideal.encoder_noise_angle == plain.encoder_noise_angle);
    BOOST_TEST(ideal.delay_in == plain.delay_in);
    BOOST_TEST(ideal.delay_out == plain.delay_out);
  }
  BOOST_TEST(plain.amplifier_bandwidth + plain.motor_force_max + plain.motor_torque_max + plain.cogging +
                 plain.breakaway + plain.breakaway_angle + plain.mode_frequency + plain.backlash + plain.encoder_noise +
                 plain.encoder_noise_angle + plain.delay_in + plain.delay_out ==
             0.0);
}

BOOST_AUTO_TEST_CASE(free_in_the_air_a_device_accelerates_by_its_mass_below_its_mode_and_peaks_at_it) {
  for (const char* file : {"phantom_premium_1_5.yaml", "touch.yaml", "omega_3.yaml"}) {
    SimulatedDevice::Params params = with_over(file);
    params.hand_mass = params.hand_damping = params.hand_stiffness = 0;
    const LinearDevice device = linear_device(params);
    // The response is worth 2 dB up to 200 Hz when two curves are compared; what it starts from is the mass.
    const double low = acceleration_response_dB(device, 5, ResponsePoint::handle);
    BOOST_TEST(std::abs(low + 20 * std::log10(params.mass)) < 0.5);
    BOOST_TEST(acceleration_response_dB(device, params.mode_frequency, ResponsePoint::handle) > low + 10);
    BOOST_TEST(acceleration_response_dB(device, 3 * params.mode_frequency, ResponsePoint::handle) < low - 10);
  }
}

BOOST_AUTO_TEST_SUITE_END()
