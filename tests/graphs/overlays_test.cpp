// Files that are laid over graphs: which nodes their names mean, over our physics and over that of others.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/graphs/every_shipped.hpp"
#include "tests/graphs/foreign_physics.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(overlays_test)

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

using Edges = std::set<std::string>;

Edges edges_of(const GraphSpec& graph) {
  Edges edges;
  for (const EdgeSpec& edge : graph.edges) edges.insert(edge.name());
  return edges;
}

Edges operator-(Edges edges, const Edges& others) {
  for (const std::string& edge : others) {
    BOOST_TEST(edges.erase(edge) == 1U, edge);
  }
  return edges;
}

Edges operator+(Edges edges, const Edges& others) {
  for (const std::string& edge : others) {
    BOOST_TEST(edges.insert(edge).second, edge);
  }
  return edges;
}

const Edges wall_edges{"trajectory.target -> device.target",
                       "device.state -> collision.device",
                       "device.state -> dynamics.device",
                       "collision.contacts -> dynamics.contacts",
                       "dynamics.state -> collision.state",
                       "coupling.parameters -> dynamics.coupling",
                       "dynamics.state -> coupling.state",
                       "coupling.force -> prediction.force",
                       "prediction.forecast -> interpolation.forecast",
                       "interpolation.segment -> device.segment",
                       "device.commanded -> metrics.commanded",
                       "coupling.force -> metrics.force",
                       "prediction.forecast -> metrics.forecast",
                       "dynamics.state -> metrics.state",
                       "device.state -> metrics.device"};
/// What a rollout in the place of prediction and interpolation takes out.
const Edges forecast_edges{"coupling.force -> prediction.force", "prediction.forecast -> interpolation.forecast",
                           "interpolation.segment -> device.segment", "prediction.forecast -> metrics.forecast"};
/// What it brings, whatever physics is called.
const Edges rollout_edges{"collision.local -> local.contacts",     "collision.contacts -> local.used",
                          "coupling.parameters -> local.coupling", "device.state -> local.device",
                          "local.model -> rollout.model",          "device.state -> rollout.device"};

Edges wall_with(const std::string& method) {
  return edges_of(loaded("wall/scene.yaml", {"methods/" + method + ".yaml"}));
}

/// A graph of physics of another kind, with what is laid over it.
class Foreign {
 public:
  explicit Foreign(const std::string& text = foreign_scene()) { write("graph.yaml", text); }

  void write(const std::string& name, const std::string& text) const {
    static_cast<void>(test::write(folder_.path() / name, text));
  }
  [[nodiscard]] GraphSpec load(const Over& over = {}, const std::string& graph = "graph.yaml") const {
    Overrides patches;
    for (const std::string& word : over) {
      const bool is_method = !fs::exists(folder_.path() / word);
      patches.push_back(word.find('=') != std::string::npos ? set_patch(word)
                        : is_method                         ? over_patch(graphs / "methods" / (word + ".yaml"))
                                                            : over_patch(folder_.path() / word));
    }
    return load_graph(folder_.path() / graph, types(), patches);
  }
  [[nodiscard]] Plan plan(const Over& over = {}) const { return make_plan(load(over)); }
  [[nodiscard]] std::string refusal(const Over& over) const {
    return refusal_of([&] { check_nodes(plan(over)); });
  }
  [[nodiscard]] std::string notes(const Over& over) const {
    std::string text;
    for (const std::string& note : check_nodes(plan(over))) text += note + "\n";
    return text;
  }

 private:
  static Registry& types() {
    static Registry all = [] {
      Registry made({TACTOR_NODE_FOLDER});
      made.add<ForeignPhysics>();
      made.add<LawListener>();
      return made;
    }();
    return all;
  }

  TemporaryFolder folder_;
};

std::string without(const std::string& text, const std::string& pattern) {
  const std::regex gone(pattern);
  BOOST_TEST(std::regex_search(text, gone), pattern << " in " << text);
  return std::regex_replace(text, gone, "");
}

}  // namespace

BOOST_AUTO_TEST_CASE(methods_over_a_scene_of_ours_make_the_edges_that_they_name) {
  BOOST_TEST((wall_with("hold") == wall_edges));
  BOOST_TEST((wall_with("floor") == wall_edges));
  BOOST_TEST((wall_with("multirate") == wall_edges + Edges{"device.state -> prediction.device"}));
  const Edges fit{"coupling.force -> refit.force", "refit.coefficients -> prediction.coefficients"};
  BOOST_TEST((wall_with("blend") == wall_edges + fit));
  BOOST_TEST((wall_with("paper") == wall_edges + fit));
  BOOST_TEST(
      (wall_with("direct") == wall_edges - Edges{"interpolation.segment -> device.segment"} +
                                  Edges{"device.state -> direct.device", "coupling.parameters -> direct.coupling",
                                        "dynamics.bodies -> direct.bodies", "interpolation.segment -> direct.otherwise",
                                        "direct.segment -> device.segment"}));
  const Edges of_ours{"dynamics.bodies -> local.bodies", "dynamics.patch -> local.patch",
                      "dynamics.state -> local.state", "dynamics.expected -> collision.expected"};
  const Edges local =
      wall_edges - forecast_edges + rollout_edges + of_ours + Edges{"rollout.segment -> device.segment"};
  BOOST_TEST((wall_with("local") == local));
  BOOST_TEST((wall_with("local_anchors") == local));
  BOOST_TEST((wall_with("forcegrid") ==
              wall_edges - Edges{"prediction.forecast -> interpolation.forecast"} +
                  Edges{"device.state -> interpolation.device", "coupling.force -> interpolation.force"}));
  BOOST_TEST((wall_with("side_by_side") ==
              wall_edges - Edges{"interpolation.segment -> device.segment"} + rollout_edges + of_ours +
                  Edges{"coupling.force -> fixed.force", "fixed.forecast -> fixed_curve.forecast",
                        "coupling.force -> refit.force", "coupling.force -> refitted.force",
                        "refit.coefficients -> refitted.coefficients", "refitted.forecast -> refitted_curve.forecast",
                        "interpolation.segment -> select.first", "fixed_curve.segment -> select.second",
                        "refitted_curve.segment -> select.third", "rollout.segment -> select.fourth",
                        "select.segment -> device.segment"}));
}

// Taken by names alone, as a file without `bind` is, every method makes the same of every scene.
BOOST_AUTO_TEST_CASE(binding_changes_no_shipped_scene, *boost::unit_test::precondition(NeedsMeshes{})) {
  const TemporaryFolder folder;
  std::vector<fs::path> by_name;
  for (const fs::path& method : yaml_files(graphs / "methods")) {
    std::string text = std::regex_replace(text_in(method), std::regex("\nbind:[^\n]*(\n  [a-z]+: [^\n]*)*"), "");
    // Ours tells no contacts of a result.
    text = std::regex_replace(text, std::regex("[^\n]*-> local.found[^\n]*\n"), "");
    text = std::regex_replace(text, std::regex(": \\{optional: true\\}"), "");
    BOOST_TEST(text.find("bind") == std::string::npos);
    by_name.push_back(write(folder.path() / method.filename(), text));
  }
  std::size_t pairs = 0;
  for (const fs::path& scene : folders_of_graphs()) {
    if (!fs::exists(scene / "scene.yaml")) continue;
    for (const fs::path& method : by_name) {
      GraphSpec before;
      const auto load = [&] { before = load_graph(scene / "scene.yaml", registry(), {over_patch(method)}); };
      if (!refusal_of(load).empty()) continue;
      BOOST_TEST_CONTEXT(scene << " " << method) {
        BOOST_TEST(to_yaml(loaded(scene / "scene.yaml", {"methods/" + method.filename().string()})) == to_yaml(before));
      }
      ++pairs;
    }
  }
  BOOST_TEST(pairs > 300U);
}

BOOST_AUTO_TEST_CASE(every_method_but_direct_fits_physics_of_another_kind) {
  const Foreign foreign;
  std::size_t methods = 0;
  for (const fs::path& file : yaml_files(graphs / "methods")) {
    const std::string method = file.stem();
    if (method == "direct") continue;
    BOOST_TEST_CONTEXT(method) {
      BOOST_TEST(foreign.refusal({method}) == "");
      const Plan plan = foreign.plan({method});
      BOOST_TEST(plan.graph.node("engine")->info->type == "mylab.physics");
      BOOST_TEST((plan.graph.node("dynamics") == nullptr));
    }
    ++methods;
  }
  BOOST_TEST(methods > 40U);
}

BOOST_AUTO_TEST_CASE(ports_follow_by_the_types_of_their_messages) {
  const Foreign foreign;
  const Edges base = edges_of(foreign.load());
  const Edges local = base - forecast_edges + rollout_edges +
                      Edges{"engine.where -> local.bodies", "engine.reading -> local.state",
                            "engine.touching -> local.found", "rollout.segment -> device.segment"};
  // No other output of bodies is there to be expected, and nothing deforms.
  BOOST_TEST((edges_of(foreign.load({"local"})) == local));
  BOOST_TEST((edges_of(foreign.load({"hold"})) == base));
  BOOST_TEST((edges_of(foreign.load({"blend"})) ==
              base + Edges{"coupling.force -> refit.force", "refit.coefficients -> prediction.coefficients"}));
  // A cost is for a node of any kind.
  const GraphSpec floor = foreign.load({"floor"});
  BOOST_TEST(floor.node("engine")->cost.base.ns == 900'000);
  BOOST_TEST((floor.node("collision")->cost.kind == CostModel::Kind::none));
}

BOOST_AUTO_TEST_CASE(a_method_takes_the_place_of_nodes_of_its_roles_whatever_they_are_called) {
  std::string odd = replaced(replaced(foreign_scene(), "prediction", "foretell"), "interpolation", "curve");
  odd = replaced(replaced(odd, "foretell.hold", "prediction.hold"), "curve.none", "interpolation.none");
  const Foreign foreign(replaced(replaced(replaced(odd, "device:", "phantom:"), "device.", "phantom."),
                                 "phantom.simulated", "device.simulated"));
  const Edges base = edges_of(foreign.load());
  const GraphSpec blend = foreign.load({"blend"});
  BOOST_TEST(blend.node("foretell")->info->type == "prediction.ar");
  BOOST_TEST(blend.node("curve")->info->type == "interpolation.blend");
  BOOST_TEST((edges_of(blend) ==
              base + Edges{"coupling.force -> refit.force", "refit.coefficients -> foretell.coefficients"}));
  BOOST_TEST((edges_of(foreign.load({"forcegrid"})) ==
              base - Edges{"foretell.forecast -> curve.forecast"} +
                  Edges{"phantom.state -> curve.device", "coupling.force -> curve.force"}));
  const GraphSpec local = foreign.load({"local"});
  BOOST_TEST((local.node("foretell") == nullptr));
  BOOST_TEST((local.node("curve") == nullptr));
  BOOST_TEST(edges_of(local).contains("rollout.segment -> phantom.segment"));
  // Of two that it could replace, none is chosen silently.
  const Foreign two(replaced(odd, "nodes:\n", "nodes:\n  second: {type: prediction.hold}\n"));
  says(two.refusal({"blend"}), "bind.prediction: expected one node of role prediction in the graph below, found 2: ");
  // A rollout is no predictor of forces: over it a hold is a new node, as it would be in a graph without any.
  const GraphSpec both = loaded("wall/scene.yaml", {"methods/local.yaml", "methods/hold.yaml"});
  BOOST_TEST(both.node("local")->info->type == "prediction.local");
  BOOST_TEST(both.node("prediction")->info->type == "prediction.hold");
}

BOOST_AUTO_TEST_CASE(direct_is_refused_where_physics_is_of_another_kind) {
  says(
      Foreign().refusal({"direct"}),
      "edge engine.where -> direct.bodies: direct steps the scene's own bodies in each tick; engine (mylab.physics) is "
      "physics of another kind");
  // Whatever its name and its ports are called, and by whoever the node is put in.
  std::string ours = replaced(foreign_scene(), "engine", "dynamics");
  says(Foreign(ours).refusal({"direct"}), "dynamics (mylab.physics) is physics of another kind");
  BOOST_TEST(refusal("wall/scene.yaml", {"methods/direct.yaml"}) == "");
}

BOOST_AUTO_TEST_CASE(where_a_role_has_no_node_what_needs_it_is_refused_and_what_does_not_is_left_out) {
  const Foreign unlinked(without(foreign_scene(), "  coupling: .*\n|  - .*coupling\\..*\n"));
  const std::string why = unlinked.refusal({"local"});
  says(why,
       "local_anchors.yaml:7:3: bind.coupling: expected a node \"coupling\" or one of role coupling in the graph "
       "below (");
  says(why, "engine");
  says(why, "found neither; add such a node to the graph");
  says(why, "bind: {coupling: {node: NAME}}");
  says_not(why, "there is no node");
  // Contacts may be those that physics tells.
  const Foreign foreign(without(foreign_scene(), "  collision: .*\n|  - .*collision\\..*\n"));
  BOOST_TEST(edges_of(foreign.load({"local"})).contains("engine.touching -> local.found"));
  BOOST_TEST(foreign.refusal({"floor"}) == "");
  BOOST_TEST((foreign.load({"floor"}).node("collision") == nullptr));
  // A parameter that a node lacks is refused by its own name.
  says(Foreign().refusal({"hold", "engine.substep=1 ms"}), "substep");
}

BOOST_AUTO_TEST_CASE(of_two_candidates_the_file_must_name_one) {
  const Foreign foreign(foreign_scene("  ghost: {type: mylab.physics}\n",
                                      "  - device.state -> ghost.hand\n  - coupling.parameters -> ghost.spring\n"));
  const std::string why = foreign.refusal({"local"});
  says(why, "bind.dynamics: expected one node of role dynamics in the graph below, found 2: ");
  says(why, "engine (mylab.physics, dynamics)");
  says(why, "ghost (mylab.physics, dynamics)");
  foreign.write("mine.yaml", "format: 2\nextends: " + (graphs / "methods/local.yaml").string() +
                                 "\nbind: {dynamics: {node: ghost}}\n");
  BOOST_TEST(edges_of(foreign.load({"mine.yaml"})).contains("ghost.where -> local.bodies"));
  foreign.write("mine.yaml", "format: 2\nextends: " + (graphs / "methods/local.yaml").string() +
                                 "\nbind: {dynamics: {node: gost}}\n");
  says(foreign.refusal({"mine.yaml"}), "bind.dynamics.node: there is no node \"gost\"");
  says(foreign.refusal({"mine.yaml"}), "did you mean \"ghost\"?");
}

BOOST_AUTO_TEST_CASE(a_node_that_has_the_name_alone_is_not_taken_for_one_that_has_the_role) {
  // In this graph the physics is called `engine`, and a predictor `dynamics`.
  const Foreign foreign(
      foreign_scene("  dynamics: {type: prediction.hold}\n", "  - coupling.force -> dynamics.force\n"));
  const std::string why = foreign.refusal({"local"});
  says(why,
       "bind.dynamics: expected a node of role dynamics, found dynamics (prediction.hold, prediction) by its name");
  says(why, "and engine (mylab.physics, dynamics) by its role");
  says(why, "bind: {dynamics: {node: NAME}}");
  foreign.write("mine.yaml", "format: 2\nextends: " + (graphs / "methods/local.yaml").string() +
                                 "\nbind: {dynamics: {node: engine}}\n");
  BOOST_TEST(edges_of(foreign.load({"mine.yaml"})).contains("engine.where -> local.bodies"));
}

BOOST_AUTO_TEST_CASE(names_bind_through_files_that_extend_each_other_and_a_method_alone_binds_to_nothing) {
  const Foreign foreign;
  foreign.write("tuned.yaml", "format: 2\nextends: " + (graphs / "methods/local_4.yaml").string() +
                                  "\nnodes: {dynamics: {cost: {constant: 3 ms}}}\nrecord: [dynamics.bodies]\n");
  const GraphSpec graph = foreign.load({"tuned.yaml"});
  BOOST_TEST(graph.node("engine")->cost.base.ns == 3'000'000);
  BOOST_TEST(graph.record == std::vector<std::string>{"engine.where"});
  foreign.write("both.yaml", "format: 2\nextends: [graph.yaml, " + (graphs / "methods/local.yaml").string() + "]\n");
  BOOST_TEST((edges_of(foreign.load({}, "both.yaml")) == edges_of(foreign.load({"local"}))));
  says(refusal("methods/local.yaml"), "methods/local.yaml, which is laid over none; a graph has a scene or a duration");
}

BOOST_AUTO_TEST_CASE(what_bind_says_is_checked) {
  const Foreign foreign;
  const auto why = [&](const std::string& bind) {
    foreign.write("own.yaml", "format: 2\nbind: " + bind + "\nedges: [dynamics.bodies -> collision.bodies]\n");
    return foreign.refusal({"own.yaml"});
  };
  BOOST_TEST(why("{dynamics: dynamics}") == "");
  says(why("{dynamics: dynamic}"), "own.yaml:2:18: bind.dynamics: expected one of");
  says(why("dynamics"), "bind: expected a map of names to roles");
  says(why("{dynamics: {optional: true}}"),
       "bind.dynamics: expected a role, or a map with role or node, found neither");
  says(why("{dynamics: {role: dynamics, optional: perhaps}}"), "bind.dynamics.optional");
  says(why("{dynamics: {role: dynamics, wanted: true}}"), "wanted");
}

BOOST_AUTO_TEST_CASE(a_node_knows_whether_physics_has_the_law_of_the_scene) {
  const std::string listener = "  ear: {type: mylab.listener}\n";
  says(Foreign(foreign_scene(listener, "  - engine.where -> ear.bodies\n")).notes({}), "foreign law\n");
  const std::string ours =
      replaced(replaced(foreign_scene(listener, "  - engine.bodies -> ear.bodies\n"), "mylab.physics", "dynamics.auto"),
               "engine.reading", "engine.state");
  says(Foreign(replaced(replaced(ours, "engine.hand", "engine.device"), "engine.spring", "engine.coupling")).notes({}),
       "law of the scene\n");
}

BOOST_AUTO_TEST_CASE(a_default_that_physics_of_another_kind_does_not_give_is_told) {
  const std::string notes = Foreign().notes({"local"});
  for (const char* node : {"local", "rollout"}) {
    const std::string name = node;
    says(notes, "node " + name +
                    ": stick_velocity should be as in the dynamics, and engine (mylab.physics) has none: its "
                    "own default 1e-04 m/s counts; give " +
                    name + ".stick_velocity to say otherwise");
  }
  // The collision is ours, and gives its own.
  says_not(notes, "as in the collision");
  says_not(Foreign().notes({"local", "local.stick_velocity=1 mm/s"}), "node local: stick_velocity");
  says_not(Foreign().notes({"hold"}), "should be as in");
  for (const char* method : {"local", "direct", "side_by_side"}) {
    says_not(notes_of("wall/scene.yaml", {std::string("methods/") + method + ".yaml"}), "should be as in");
  }
}

BOOST_AUTO_TEST_CASE(methods_run_over_physics_of_another_kind) {
  const Foreign foreign;
  for (const char* method : {"hold", "blend", "paper", "floor", "local"}) {
    BOOST_TEST_CONTEXT(method) {
      const RunResult result = run(foreign.plan({method}));
      BOOST_TEST(result.metric("contacts.max") > 0);
      BOOST_TEST(std::isfinite(result.metric("delivered.force.rms_error_N")));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
