// Shipped graphs: their format, their scenes and methods for a while, their rates.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "app/lean/physics_fit.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/migrate.hpp"
#include "tests/graphs/every_shipped.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(shipped_graphs_test, *boost::unit_test::precondition(tactor::test::NeedsMeshes{}))

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

BOOST_AUTO_TEST_CASE(every_file_says_its_format_and_none_has_former_names) {
  Registry all({TACTOR_NODE_FOLDER});
  all.load_all();
  const std::vector<const NodeInfo*> types = all.types();
  std::size_t files = 0;
  for (const fs::path& folder : folders_of_graphs()) {
    for (const fs::path& file : yaml_files(folder)) {
      Diagnostics diagnostics;
      BOOST_TEST_CONTEXT(file) {
        says_like(text_in(file), "(^|\n)format: 2\\b");
        BOOST_TEST(migrate(text_in(file), file.string(), types, diagnostics).changes.empty());
        BOOST_TEST(!diagnostics.any());
      }
      ++files;
    }
  }
  BOOST_TEST(files > 100U);
}

BOOST_AUTO_TEST_CASE(every_method_runs_over_a_scene) {
  const std::vector<fs::path> methods = yaml_files(graphs / "methods");
  BOOST_TEST(methods.size() > 10U);
  with_each(methods, [](const fs::path& method) {
    const Plan plan = planned("wall/scene.yaml", {method.string(), "duration=1.2 s"});
    const RunResult result = run_for_page(plan);
    BOOST_TEST(result.metric("contacts.max") > 0);
    BOOST_TEST(std::isfinite(result.metric("delivered.force.rms_error_N")));
    check_told(result, plan.graph);
  });
}

BOOST_AUTO_TEST_CASE(every_renderer_and_passive_stage_is_judged_over_a_scene) {
  std::vector<fs::path> files = yaml_files(graphs / "renderers");
  BOOST_TEST(files.size() > 5U);
  for (const char* name : {"waves", "controller", "energy_bound"}) {
    files.push_back(graphs / "passivity" / (name + std::string(".yaml")));
  }
  with_each(files, [](const fs::path& file) {
    Over over{file.string(), "duration=1.2 s"};
    // Its mean over 10 ms, which the reference run has too, would leave that no finer than the run.
    if (file.stem() == "waves") over = over + Over{"passivity/delay_10ms.yaml", "coupling.period_min=1 ms"};
    const RunResult result = run(planned("wall/scene.yaml", over));
    BOOST_TEST(std::isfinite(result.metric("delivered.force.rms_error_N")), result.reference.too_coarse);
  });
}

BOOST_AUTO_TEST_CASE(the_scene_of_every_folder_runs) {
  std::vector<fs::path> scenes = graphs_with_clock(Clock::virtual_);
  std::erase_if(scenes, [](const fs::path& graph) { return graph.stem() != "scene"; });
  BOOST_TEST(scenes.size() > 10U);
  with_each(scenes, [](const fs::path& scene) {
    const Plan plan = planned(scene, with_few_tetrahedra(scene, {"duration=0.6 s"}));
    const RunResult result = run_for_page(plan);
    BOOST_TEST(std::isfinite(result.metric("delivered.force.rms_error_N")));
    BOOST_TEST(result.metric("drops") == 0);
    check_told(result, plan.graph);
  });
}

BOOST_AUTO_TEST_CASE(live_graphs_say_their_clock_lanes_and_settings) {
  const std::vector<fs::path> live = graphs_with_clock(Clock::real);
  BOOST_TEST(live.size() >= 2U);
  with_each(live, [](const fs::path& graph) {
    const std::string text = explained(graph);
    says(text, "clock real");
    says(text, "a missing privilege: warn");
    says_like(text, "node +type +steps +cost +lane");
    BOOST_CHECK_NO_THROW(measure_physics_fit(planned(graph), [] { return false; }));
  });
}

BOOST_AUTO_TEST_CASE(one_rate_drives_the_whole_haptic_loop) {
  for (const auto& [graph, follows] :
       {std::pair{"duck/blend.yaml", "interpolation"}, std::pair{"bunny/local.yaml", "rollout"}}) {
    for (const std::string setting : {"rate=4 kHz", "device.rate=4000"}) {
      BOOST_TEST_CONTEXT(graph << " " << setting) {
        const Plan plan = planned(graph, {setting, "duration=0.3 s"});
        const std::string text = explain(plan, 1000);
        says(text, "haptic loop at 4000 Hz");
        says_not(text, "at 1000 Hz");
        const RunResult result = run(plan);
        BOOST_TEST(node_of(result, "trajectory").steps == 1200U);
        BOOST_TEST(node_of(result, "device").steps == 1200U);
        // It steps on what arrives too.
        near(static_cast<double>(node_of(result, follows).steps), 1225, 25);
      }
    }
  }
  says(explained("duck/blend.yaml"), "haptic loop at 1000 Hz");
}

BOOST_AUTO_TEST_CASE(two_rates_of_the_haptic_loop_are_refused) {
  const TemporaryFolder folder;
  const fs::path graph = write(folder.path() / "two.yaml", "extends: " + (graphs / "duck/blend.yaml").string() +
                                                               "\nnodes:\n  device: {rate: 4 kHz}\n"
                                                               "  interpolation: {rate: 1 kHz}\n");
  BOOST_TEST(refusal_of_run(graph) ==
             graph.string() + ":4:25: nodes.interpolation.rate: expected 4 kHz as in nodes.device.rate (" +
                 graph.string() +
                 ":3:18), found 1 kHz; all nodes of the haptic loop step at one rate: give it once, as the graph's "
                 "rate, and take it out of the nodes");
}

BOOST_AUTO_TEST_CASE(a_field_of_forces_is_refused_where_the_tool_rotates_or_the_spring_is_another) {
  for (const auto& [method, name] :
       {std::pair{"forcegrid.yaml", "forcefield.grid"}, std::pair{"rbf.yaml", "forcefield.rbf"}}) {
    const fs::path graph = fs::path("duck") / method;
    const Over rigid{"scene.bodies.tool.motion=rigid"};
    for (const std::string& error : {refusal(graph, rigid), refusal_of_run(graph, rigid)}) {
      says(error, "methods/" + std::string(method) + ":5:");
      says(error, "node interpolation: " + std::string(name) + ": ");
      says(error, "the tool 'tool' rotates");
      says(error, "use a prediction.* and an interpolation.* in its place");
    }
  }
  const std::string error =
      refusal_of([] { execute(planned("duck/rbf.yaml", {"interpolation.k_t=500"}), {.without_reference = true}); });
  says(error, "interpolation");
  says(error, "this one has 353.553391 N/m; set its k_t");
}

BOOST_AUTO_TEST_SUITE_END()
