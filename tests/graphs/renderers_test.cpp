// The standard renderers laid over shipped scenes: what they leave out, and when they vibrate.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "tests/graphs/every_shipped.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(renderers_test)

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const std::string wall = "wall/scene.yaml";

std::string file_of(const std::string& renderer) {
  return "renderers/" + renderer + ".yaml";
}

/// How many of collision, dynamics and coupling a plan leaves out, which a check must not refuse.
int physics_left_out(const fs::path& graph, const Over& over) {
  const Plan plan = planned(graph, over);
  check_nodes(plan);
  return static_cast<int>(std::count_if(plan.left_out.begin(), plan.left_out.end(), [](const LeftOut& left) {
    return left.what == "node collision" || left.what == "node dynamics" || left.what == "node coupling";
  }));
}

RunResult unjudged_run(const fs::path& graph, const Over& over, const std::vector<Listener>& listeners = {}) {
  return run(planned(graph, over), listeners, {.without_reference = true});
}

}  // namespace

BOOST_AUTO_TEST_CASE(overlays_fit_a_scene_and_leave_out_what_the_proxy_stands_for) {
  with_each(yaml_files(graphs / "renderers"), [](const fs::path& over) {
    BOOST_TEST(physics_left_out(wall, {over.string()}) == (over.stem() == "proxy" ? 3 : 0));
  });
}

BOOST_AUTO_TEST_CASE(effects_hear_of_contact_from_what_makes_the_force) {
  BOOST_TEST(physics_left_out(wall, {file_of("proxy"), file_of("impact_and_texture")}) == 3);
  // A spring without physics tells of no contact.
  check_nodes(planned("virtual_wall/scene.yaml", {file_of("impact_by_force"), file_of("texture_by_force")}));
  says(refusal("virtual_wall/scene.yaml", {file_of("impact")}), "metrics.state");
}

BOOST_AUTO_TEST_CASE(a_slow_proxy_is_as_the_fast_one_at_its_samples) {
  std::vector<Stamped<Wrench>> slow, fast;
  unjudged_run(wall, {file_of("proxy_slow"), "duration=3 s", "record=[coupling.force]"},
               {kept("coupling.force", slow)});
  unjudged_run(wall, {file_of("proxy"), "duration=3 s", "record=[interpolation.force]"},
               {kept("interpolation.force", fast)});
  std::map<Time, Vec3> at;
  for (const Stamped<Wrench>& message : fast) at[message.stamp.valid] = message.value.force;
  BOOST_TEST(slow.size() > 200U);
  BOOST_TEST(slow.size() < 450U);
  for (const Stamped<Wrench>& message : slow) {
    BOOST_TEST_REQUIRE(at.contains(message.stamp.valid));
    BOOST_TEST((message.value.force == at.at(message.stamp.valid)));
  }
}

BOOST_AUTO_TEST_CASE(taps_on_a_device_vibrate_within_its_limits) {
  std::vector<Stamped<Wrench>> commanded;
  const RunResult result =
      unjudged_run(wall, {file_of("impact"), "devices/omega_3.yaml", "device.loop=closed", "duration=6 s"},
                   {kept("device.commanded", commanded)});
  BOOST_TEST(result.metric("impact.events") >= 2);
  BOOST_TEST(result.metric("device.rejected_segments") == 0);
  BOOST_TEST(result.metric("device.slewed_ticks") == 0);
  BOOST_TEST_REQUIRE(!commanded.empty());
  for (const Stamped<Wrench>& message : commanded) BOOST_TEST_REQUIRE(norm(message.value.force) <= 8);
}

BOOST_AUTO_TEST_CASE(a_tool_in_the_air_meets_nothing_however_heavy_it_is) {
  // Slowly up, then fast, and aside: all 30 mm above the wall or more. Then down onto it, and aside.
  const TemporaryFolder folder;
  const fs::path lifted = write(folder.path() / "lifted.yaml", "extends: " + (graphs / wall).string() + R"(
scene: {bodies: {tool: {mass: 150 g}}}
nodes:
  trajectory:
    interpolation: linear
    tremor_amplitude: 0
    points: [{t: 0 s, z: 40 mm}, {t: 0.5 s, z: 40 mm}, {t: 1.5 s, z: 90 mm}, {t: 1.6 s, z: 130 mm}, {t: 2 s, z: 130 mm},
             {t: 3 s, x: 50 mm, z: 130 mm}, {t: 3.8 s, x: 50 mm, z: -1 mm}, {t: 4.5 s, x: 80 mm, z: -1 mm}]
)");
  const auto effects = [&lifted](const std::string& gravity, const std::string& how, const std::string& duration) {
    const RunResult result = unjudged_run(lifted, {file_of("impact" + how), file_of("texture" + how),
                                                   "scene.gravity=[0, 0, " + gravity + "]", "duration=" + duration});
    return std::pair{result.metric("impact.events"), result.metric("texture.sliding_ticks")};
  };
  BOOST_TEST(effects("0", "_by_force", "3 s").first > 0);         // inertia
  BOOST_TEST(effects("-9.81", "_by_force", "3 s").second > 500);  // weight
  for (const std::string gravity : {"0", "-9.81"}) {
    BOOST_TEST((effects(gravity, "", "3 s") == std::pair{0.0, 0.0}));
    const auto [events, ticks] = effects(gravity, "", "4.5 s");
    BOOST_TEST(events == 1);
    BOOST_TEST(ticks > 500);
  }
}

BOOST_AUTO_TEST_CASE(a_vibration_takes_the_device_s_parameters_unless_it_is_told_others) {
  const Over omega{file_of("impact"), "devices/omega_3.yaml", "duration=0.1 s"};
  BOOST_TEST(unjudged_run(wall, omega).metric("impact.match_error") > 0.05);
  BOOST_TEST(unjudged_run(wall, omega + Over{"impact.mode_frequency=0 Hz"}).metric("impact.match_error") < 0.01);
}

BOOST_AUTO_TEST_SUITE_END()
