// Stages that keep the port passive, laid over the scenes: the energy is summed up here from what the device got.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <string>
#include <utility>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "tests/graphs/port_energy.hpp"
#include "tests/support/page_text.hpp"

BOOST_AUTO_TEST_SUITE(passive_stages_test)

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const std::vector<std::string> stages{"controller", "energy_bound"};
const fs::path wall = "wall/closed_loop.yaml";

std::string file_of(const std::string& stage) {
  return "passivity/" + stage + ".yaml";
}

Played staged(const fs::path& graph, const std::string& method, const std::string& stage, const Over& settings) {
  Over over{"methods/" + method + ".yaml"};
  if (!stage.empty()) over.push_back(file_of(stage));
  return played(graph, over + settings);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_wall_that_gives_energy_gives_no_more_than_a_tick_and_a_rounding_with_a_stage) {
  const Over stiff{"coupling.k_t=6400 N/m", "scene.bodies.wall.material.stiffness=100 N/mm",
                   "scene.bodies.tool.material.stiffness=100 N/mm", "device.hand_mass=0.15 kg"};
  for (const std::string stage : {"", "controller", "energy_bound"}) {
    BOOST_TEST_CONTEXT("stage " << stage) {
      const Played found = staged(wall, "hold", stage, stiff);
      const PortEnergy given = energy_of(found);
      const auto metric = [&](const char* name) { return found.run.metric(name); };
      near(metric("port.energy_generated_J"), given.most, 1e-9);
      near(metric("port.energy_allowed_J"), given.allowed, 1e-3 * given.allowed);
      // What the simulated motors know of themselves, by their sub-steps.
      near(metric("device.energy_generated_J"), given.most, 1e-3 * given.allowed);
      BOOST_TEST(metric("stability.passive") == (stage.empty() ? 0 : 1));
      if (stage.empty()) {
        BOOST_TEST(given.most > 100 * given.allowed);
      } else {
        BOOST_TEST(given.most <= given.allowed);
        BOOST_TEST(metric("passivity.changed_share") > 0.01);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_run_that_is_passive_is_left_as_it_is) {
  const Over judged_by_nobody{"metrics=~", "duration=3 s"};
  const std::vector<std::pair<fs::path, std::string>> runs{
      {"wall/scene.yaml", "local"}, {"wall/scene.yaml", "hold"}, {wall, "local"}};
  for (const auto& [graph, method] : runs) {
    const Played plain = staged(graph, method, "", judged_by_nobody);
    BOOST_TEST_REQUIRE(plain.force.size() > 2900U);
    for (const std::string& stage : stages) {
      BOOST_TEST_CONTEXT(graph << " " << method << " " << stage) {
        const Played found = staged(graph, method, stage, judged_by_nobody);
        BOOST_TEST((found.force == plain.force));
        BOOST_TEST((found.handle == plain.handle));
        BOOST_TEST(found.run.metric("passivity.changed_share") == 0);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_stage_goes_between_the_method_and_the_device_whatever_the_method) {
  const std::vector<std::pair<std::string, std::string>> methods{
      {"hold", "interpolation.segment"}, {"local", "rollout.segment"}, {"direct", "direct.segment"}};
  for (const auto& [method, source] : methods) {
    for (const std::string& stage : stages) {
      BOOST_TEST_CONTEXT(method << " " << stage) {
        const std::string text = explained(wall, {"methods/" + method + ".yaml", file_of(stage)});
        says(text, "passivity." + stage);
        says(text, source + " -> passivity.segment");
        says(text, "passivity.segment -> device.segment");
      }
    }
  }
  // One stage takes the place of the other, and none twice.
  const std::string text = explained(wall, {file_of("controller"), file_of("energy_bound"), file_of("energy_bound")});
  says(text, "passivity.energy_bound");
  says_not(text, "passivity.controller");
  says(text, "interpolation.segment -> passivity.segment");
}

BOOST_AUTO_TEST_CASE(an_edge_from_what_feeds_an_input_needs_one_that_feeds_it) {
  const TemporaryFolder folder;
  const fs::path child =
      write(folder.path() / "child.yaml",
            "extends: " + (graphs / wall).string() + "\nedges: [into device.segmnt -> metrics.commanded]\n");
  says(refusal(child),
       "into device.segmnt: expected an edge into device.segmnt in the file that this one is laid over");
}

BOOST_AUTO_TEST_CASE(bad_parameters_are_refused) {
  const std::vector<std::pair<std::string, std::string>> bad{
      {"controller", "damping_share=2"},      {"controller", "mass=0"},
      {"energy_bound", "acceleration=-1"},    {"energy_bound", "rounding=1.5"},
      {"energy_bound", "stiffness_min=0"},    {"controller", "lever=0"},
      {"energy_bound", "device_damping=1 kg"}};
  for (const auto& [stage, value] : bad) {
    says(refusal(wall, {file_of(stage), "passivity." + value}),
         "passivity." + value.substr(0, value.find('=')) + ": expected ");
  }
}

BOOST_AUTO_TEST_SUITE_END()
