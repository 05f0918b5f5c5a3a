// A line of wave variables between the handle and physics that is away: what left and what the port gave are summed up
// here.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/graphs/port_energy.hpp"
#include "tests/support/page_text.hpp"

BOOST_AUTO_TEST_SUITE(wave_line_test)

using namespace tactor;
using namespace tactor::test;

namespace {

const std::string wall = "wall/closed_loop.yaml", waves = "passivity/waves.yaml";
const Over stiff{"scene.bodies.wall.material.stiffness=100 N/mm", "scene.bodies.tool.material.stiffness=100 N/mm"};

std::string away(int ms) {
  return "passivity/delay_" + std::to_string(ms) + "ms.yaml";
}

/// The mean of the z components from `begin` up to `end`.
double mean_z(const std::vector<Vec3>& vectors, std::size_t begin, std::size_t end) {
  BOOST_REQUIRE(end <= vectors.size());
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += vectors[i].z;
  return sum / static_cast<double>(end - begin);
}

double largest(const Vec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

BOOST_AUTO_TEST_CASE(with_physics_50_ms_away_a_held_force_gives_energy_and_a_line_of_waves_none) {
  const Played hold = played(wall, Over{away(50)} + stiff + Over{"coupling.k_t=800 N/m", "device.hand_mass=0.15 kg"});
  const PortEnergy of_hold = energy_of(hold);
  BOOST_TEST(of_hold.most > 10 * of_hold.allowed);
  BOOST_TEST(hold.run.metric("stability.passive") == 0);
  for (const std::string hand : {"device.hand_mass=0.15 kg", "device.hand_mass=0.55 kg", "device.hand_damping=0"}) {
    for (const int ms : {10, 50, 100}) {
      BOOST_TEST_CONTEXT(hand << ", " << ms << " ms") {
        const Played found = played(wall, Over{waves, away(ms)} + stiff + Over{hand});
        const PortEnergy given = energy_of(found);
        BOOST_TEST(given.most <= given.allowed);
        BOOST_TEST(found.run.metric("stability.passive") == 1);
        // It is a wall all the same: the handle is pushed out of it.
        BOOST_TEST(std::any_of(found.force.begin(), found.force.end(), [](const Vec3& f) { return f.z > 0.5; }));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(what_leaves_is_of_the_force_commanded_and_of_the_way_that_the_encoder_showed) {
  constexpr double b = 12, period = 1e-3;
  std::vector<Stamped<DeviceState>> state, wave;
  const Played found = played(wall, {waves, away(10), "coupling.impedance=12 N s/m"},
                              {kept("device.state", state), kept("coupling.wave", wave)});
  BOOST_TEST_REQUIRE(state.size() > 1000U);
  BOOST_TEST_REQUIRE(found.force.size() + 1 >= state.size());
  Vec3 out = state[0].value.X_WD.p;
  double apart = 0, wrong = 0, energy_out = 0, energy_played = 0;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Vec3 p = state[i].value.X_WD.p;
    if (i > 0) {
      const Vec3 way = p - state[i - 1].value.X_WD.p, damped = period / b * found.force[i - 1];
      out += way - damped;
      energy_out += dot(way - damped, way - damped);
      energy_played += dot(way + damped, way + damped);
    }
    apart = std::max(apart, largest(out - p));
    if (i < wave.size()) wrong = std::max(wrong, largest(out - wave[i].value.X_WD.p));
  }
  BOOST_TEST(wave.size() > 1000U);
  BOOST_TEST(wrong < 1e-12);
  BOOST_TEST(apart > 1e-3);
  const double left = found.run.metric("waves.energy_out_J"), came = found.run.metric("waves.energy_played_J");
  near(left, 0.25 * b * energy_out / period, 1e-3 * left);
  near(came, 0.25 * b * energy_played / period, 1e-3 * came);
  BOOST_TEST(came < left);
}

BOOST_AUTO_TEST_CASE(at_rest_it_is_as_stiff_as_the_impedance_over_half_the_time_there_and_back) {
  for (const auto& [ms, b] : {std::pair{0, 10}, std::pair{50, 20}}) {
    BOOST_TEST_CONTEXT(ms << " ms") {
      Over over{waves};
      if (ms > 0) over.push_back(away(ms));
      const Played found = played(
          wall, over + stiff +
                    Over{"coupling.impedance=" + std::to_string(b) + " N s/m", "duration=6 s", "device.friction=0"});
      const std::size_t end = found.force.size();
      BOOST_TEST_REQUIRE(end > 2000U);
      // Half a period of physics until a wave is in a result, as much until it is played, a tick and a half, and the
      // ways. The query goes on for a period while samples are still under way.
      const double half = 0.5 * (11.7e-3 + std::max(11.7e-3, 1e-3 * ms) + 1e-3 * ms + 1.5e-3);
      const double expected = 1 / (half / b + 2 / 1e5);
      near(mean_z(found.force, end - 2000, end) / (4e-3 - mean_z(found.handle, end - 2000, end)), expected,
           0.1 * expected);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_heavy_tool_is_felt_and_its_weight_gives_no_more_than_on_the_way_of_the_handle) {
  // A hand that stands, goes up and comes down to the wall.
  const std::string points =
      "trajectory.points=[{t: 0 s, z: 40 mm}, {t: 1.2 s, z: 40 mm}, {t: 1.6 s, z: 60 mm}, {t: 3 s, z: 60 mm}, "
      "{t: 4 s, z: 0 mm}, {t: 6 s, z: 0 mm}]";
  const std::vector<std::tuple<std::string, double, int>> tools{
      {"0.05", 0.05, 50}, {"0.2", 0.2, 10}, {"0.2", 0.2, 50}, {"0.5", 0.5, 100}};
  for (const auto& [mass, kg, ms] : tools) {
    BOOST_TEST_CONTEXT(mass << " kg, " << ms << " ms") {
      const Played found =
          played(wall, Over{waves, away(ms)} + stiff +
                           Over{"scene.gravity=[0, 0, -9.81]", "scene.bodies.tool.mass=" + mass + " kg", points,
                                "duration=6 s", "device.hand_stiffness=400 N/m"});
      BOOST_TEST(found.run.metric("port.energy_generated_J") <= found.run.metric("port.energy_allowed_J"));
      BOOST_TEST(found.run.metric("stability.passive") == 1);
      near(mean_z(found.force, 2500, 3000), -9.81 * kg, 0.15 * 9.81 * kg);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_tool_that_starts_away_from_the_handle_is_refused) {
  const RunResult result =
      execute(planned(wall, {waves, "dynamics.start_at_device=false"}), {.without_reference = true});
  BOOST_TEST_REQUIRE(result.failure.has_value());
  says(*result.failure, "start_at_device is false, and the coupling is a damper without a spring");
}

BOOST_AUTO_TEST_CASE(the_line_takes_the_place_of_the_coupling_whatever_the_method) {
  for (const Over& method : {Over{}, Over{"methods/hold.yaml"}, Over{"methods/blend.yaml"}}) {
    const std::string text = explained(wall, method + Over{waves, away(50)});
    for (const char* edge : {"coupling.wave -> collision.device", "coupling.wave -> dynamics.device",
                             "coupling.parameters -> dynamics.coupling", "dynamics.state -> coupling.state",
                             "coupling.segment -> device.segment", "passivity.waves"}) {
      says(text, edge);
    }
    int delays = 0;
    for (std::size_t at = 0; (at = text.find("delay 50", at)) != std::string::npos; ++at) ++delays;
    BOOST_TEST(delays == 3);
  }
}

BOOST_AUTO_TEST_CASE(what_it_cannot_do_is_refused) {
  const std::vector<std::pair<Over, std::string>> refused{
      {{"coupling.impedance=0"}, "coupling.impedance: expected a damping (N s/m) above 0"},
      {{"coupling.impedance=5 kg"}, "coupling.impedance: expected a damping (N s/m), found"},
      {{"coupling.impedance=26 N s/m"}, "expected at most a quarter of mass * rate, 25 N s/m"},
      {{"coupling.catch_up=0 s"}, "coupling.catch_up: expected a time (s) from 0.001 to 10, found"},
      {{"scene.bodies.tool.motion=rigid", "dynamics.type=dynamics.rigid"}, "no torques"},
      {{"dynamics.type=dynamics.quasistatic"}, "its tool has no damper"}};
  for (const auto& [settings, words] : refused) says(refusal(wall, Over{waves} + settings), words);
}

BOOST_AUTO_TEST_SUITE_END()
