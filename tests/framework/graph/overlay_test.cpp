// What is written of the difference of two graphs loads to the second one.
#include <boost/test/unit_test.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "framework/graph/plan.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(overlay_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

struct Fixture {
  Registry registry = test_registry();
  Folder folder;

  GraphSpec base() {
    static_cast<void>(folder.write("base.yaml", pipeline(rigid_scene)));
    return load_graph(folder.path() / "base.yaml", registry);
  }
  /// The text of `changed` over the base, and what it loads to.
  std::pair<std::string, GraphSpec> written(const GraphSpec& from, const GraphSpec& changed) {
    const std::string text = to_overlay(from, changed, "changed", {"base.yaml"});
    return {text, load_graph(folder.write("changed.yaml", text), registry)};
  }
};

NodeSpec& node(GraphSpec& graph, const std::string& name) {
  for (NodeSpec& found : graph.nodes) {
    if (found.name == name) return found;
  }
  throw std::runtime_error("no node " + name);
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(nothing_changed_is_nothing_but_a_title, Fixture) {
  const GraphSpec from = base();
  const auto [text, loaded] = written(from, from);
  BOOST_TEST(text == "title: \"changed\"\nextends: [\"base.yaml\"]\n");
  GraphSpec expected = from;
  expected.title = "changed";
  BOOST_TEST(to_yaml(loaded) == to_yaml(expected));
}

BOOST_FIXTURE_TEST_CASE(parameters_bodies_types_and_edges_load_to_what_was_changed, Fixture) {
  const GraphSpec from = base();
  GraphSpec changed = from;
  changed.title = "changed";
  NodeSpec& coupling = node(changed, "coupling");
  coupling.params.at(coupling.info->param("stiffness").value()) = 321.0;
  changed.scene.bodies[0].motion = Motion::translation;
  changed.scene.bodies[0].material.friction = 0;
  changed.scene.bodies[1].material.damping = 7;
  node(changed, "collision").cost.base = Duration::from_seconds(0.001);
  std::erase_if(changed.edges, [](const EdgeSpec& edge) { return edge.to_port == "coefficients"; });
  const auto [text, loaded] = written(from, changed);
  BOOST_TEST(to_yaml(loaded) == to_yaml(changed));
  // Only what differs is told.
  for (const char* word : {"stiffness: 321", "motion: translation", "friction: 0", "damping: 7", "coefficients: ~"}) {
    BOOST_TEST(text.find(word) != std::string::npos, word << " in\n" << text);
  }
  for (const char* word : {"dynamics:", "device:", "mass", "seed", "record"}) {
    BOOST_TEST(text.find(word) == std::string::npos, word << " in\n" << text);
  }
}

BOOST_FIXTURE_TEST_CASE(a_cost_is_told, Fixture) {
  const GraphSpec from = base();
  GraphSpec changed = from;
  changed.title = "changed";
  NodeSpec& hold = node(changed, "hold");
  hold.cost.kind = CostModel::Kind::constant;
  hold.cost.base = Duration::from_seconds(0.002);
  const auto [text, loaded] = written(from, changed);
  BOOST_TEST(to_yaml(loaded) == to_yaml(changed));
}

BOOST_AUTO_TEST_SUITE_END()
