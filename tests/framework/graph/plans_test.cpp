// A plan holds what the scene needs, in the order of the data, and says what it left out and why.
#include <algorithm>
#include <boost/test/unit_test.hpp>

#include "framework/graph/plan.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(plans_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

struct Fixture {
  Folder folder;

  Plan plan(const std::string& text, const std::vector<std::string>& set = {}) {
    return make_plan(load_text(folder, text, settings(set)));
  }
};

std::vector<std::string> names(const Plan& plan) {
  std::vector<std::string> result;
  for (const NodeSpec& node : plan.nodes) result.push_back(node.name);
  return result;
}

bool has(const Plan& plan, const std::string& name) {
  const std::vector<std::string> all = names(plan);
  return std::find(all.begin(), all.end(), name) != all.end();
}

std::string why(const Plan& plan, const std::string& what) {
  for (const LeftOut& left : plan.left_out) {
    if (left.what == what) return left.why;
  }
  return {};
}

const PlannedEdge* edge(const Plan& plan, const std::string& name) {
  for (const PlannedEdge& e : plan.edges) {
    if (e.spec.name() == name) return &e;
  }
  return nullptr;
}

std::size_t position(const Plan& plan, const std::string& name) {
  const std::vector<std::string> all = names(plan);
  return static_cast<std::size_t>(std::find(all.begin(), all.end(), name) - all.begin());
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  BOOST_REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_scene_that_needs_everything_keeps_everything, Fixture) {
  const Plan p = plan(pipeline(rigid_scene));
  BOOST_TEST(p.torque);
  BOOST_TEST(p.nodes.size() == 8U);
  BOOST_TEST(p.edges.size() == 13U);
  BOOST_TEST(p.left_out.empty());
  BOOST_TEST_REQUIRE(p.streams.size() == 1U);
  BOOST_TEST(p.nodes[p.streams[0].node].name == "coupling");
  BOOST_TEST(p.nodes[p.streams[0].node].info->outputs[p.streams[0].output].name == "force");
}

BOOST_FIXTURE_TEST_CASE(a_type_that_stands_for_others_becomes_the_one_that_suits_the_scene, Fixture) {
  GraphSpec graph = load_text(folder, pipeline(rigid_scene), settings({"collision.margin=3 mm"}));
  const auto node =
      std::find_if(graph.nodes.begin(), graph.nodes.end(), [](const NodeSpec& n) { return n.name == "collision"; });
  // The chosen type has a parameter of its own beside the one that is passed on.
  const NodeInfo plain = *node->info;
  NodeInfo chosen = plain;
  chosen.type = "test.chosen";
  ParamInfo own = plain.params.front();
  own.name = "own";
  own.default_value = 0.07;
  chosen.params.insert(chosen.params.begin(), own);
  chosen.unneeded = nullptr;
  NodeInfo any = plain;
  any.type = "test.any";
  any.nature = StandIn{[&](const Scene& scene) {
    return scene.rotates() ? Resolution{&chosen, "the scene rotates"} : Resolution{&plain, "the scene does not rotate"};
  }};
  node->info = &any;

  const Plan p = make_plan(graph);
  BOOST_TEST_REQUIRE(p.chosen.size() == 1U);
  BOOST_TEST(p.chosen[0].node == "collision");
  BOOST_TEST(p.chosen[0].asked == "test.any");
  BOOST_TEST(p.chosen[0].type == "test.chosen");
  BOOST_TEST(p.chosen[0].why == "the scene rotates");
  const NodeSpec& planned = p.nodes[position(p, "collision")];
  BOOST_TEST(planned.info == &chosen);
  BOOST_TEST_REQUIRE(planned.params.size() == 2U);
  BOOST_TEST(std::get<double>(planned.params[0]) == 0.07);
  BOOST_TEST(std::get<double>(planned.params[1]) == 0.003);
  BOOST_TEST(planned.cost.base.seconds() == 0.006, boost::test_tools::tolerance(1e-12));
  const std::string text = explain(p);
  BOOST_TEST(text.find("collision  test.any is test.chosen  the scene rotates") != std::string::npos);
  // A reference run has what the run under test had.
  BOOST_TEST(make_reference_plan(p).chosen.empty());

  // In another scene it is another type, which may then be left out.
  graph.scene.bodies.pop_back();
  graph.scene.bodies[0].motion = Motion::translation;
  const Plan other = make_plan(graph);
  BOOST_TEST(other.chosen[0].why == "the scene does not rotate");
  BOOST_TEST(why(other, "node collision") == "the scene has nothing to hit");
}

BOOST_FIXTURE_TEST_CASE(edges_point_at_the_nodes_and_ports_they_name, Fixture) {
  const Plan p = plan(pipeline(rigid_scene));
  for (const PlannedEdge& e : p.edges) {
    BOOST_TEST(p.nodes[e.from].name == e.spec.from_node);
    BOOST_TEST(p.nodes[e.from].info->outputs[e.output].name == e.spec.from_port);
    BOOST_TEST(p.nodes[e.to].name == e.spec.to_node);
    BOOST_TEST(p.nodes[e.to].info->inputs[e.input].name == e.spec.to_port);
  }
}

BOOST_FIXTURE_TEST_CASE(a_refitter_is_left_out_under_fixed_coefficients, Fixture) {
  const Plan p = plan(pipeline(rigid_scene), {"predictor.adaptive=false"});
  BOOST_TEST(!has(p, "refit"));
  BOOST_TEST(why(p, "node refit") == "its outputs reach no sink and no recording");
  BOOST_TEST(why(p, "edge refit.coefficients -> predictor.coefficients") == "the coefficients are fixed");
  BOOST_TEST(why(p, "edge coupling.force -> refit.force") == "refit is left out");
}

BOOST_FIXTURE_TEST_CASE(collision_is_left_out_where_there_is_nothing_to_hit, Fixture) {
  const Plan p = plan(pipeline("  bodies:\n    tool: {sphere: {radius: 4 mm}, motion: rigid}\n"));
  BOOST_TEST(!has(p, "collision"));
  BOOST_TEST(why(p, "node collision") == "the scene has nothing to hit");
  // The device then is what makes the dynamics step.
  BOOST_TEST_REQUIRE(edge(p, "device.state -> dynamics.device") != nullptr);
  BOOST_TEST(edge(p, "device.state -> dynamics.device")->triggers);
}

BOOST_FIXTURE_TEST_CASE(a_trigger_when_alone_rests_beside_another_trigger, Fixture) {
  const Plan p = plan(pipeline(rigid_scene));
  BOOST_TEST(edge(p, "collision.contacts -> dynamics.contacts")->triggers);
  BOOST_TEST(!edge(p, "device.state -> dynamics.device")->triggers);
  BOOST_TEST(!edge(p, "coupling.parameters -> dynamics.coupling")->triggers);
  BOOST_TEST(!edge(p, "hold.segment -> device.segment")->triggers);
}

BOOST_FIXTURE_TEST_CASE(torque_is_left_out_of_a_translation_only_scene, Fixture) {
  const std::string graph = replaced(pipeline(sliding_scene), "  judge: {type: test.judge}\n",
                                     "  judge: {type: test.judge}\n  twist: {type: test.twist}\n");
  const std::string connected =
      replaced(graph, "record:\n", "  - coupling.force -> twist.force\nrecord:\n  - twist.out\n");
  const Plan p = plan(connected);
  BOOST_TEST(!p.torque);
  BOOST_TEST(why(p, "torque") == "the scene is translation-only");
  BOOST_TEST(why(p, "node twist") == "the scene is translation-only");
  BOOST_TEST(why(p, "recording twist.out") == "twist is left out");
  BOOST_TEST(p.streams.size() == 1U);
  BOOST_TEST(has(plan(replaced(connected, "motion: translation", "motion: rigid")), "twist"));
}

BOOST_FIXTURE_TEST_CASE(a_node_that_reaches_nothing_is_left_out_unless_it_is_recorded, Fixture) {
  const std::string graph =
      replaced(replaced(pipeline(rigid_scene), "  judge: {type: test.judge}\n",
                        "  judge: {type: test.judge}\n  a: {type: test.gate}\n  b: {type: test.gate}\n"),
               "record:\n", "  - coupling.force -> a.in\n  - a.out -> b.in\nrecord:\n");
  const Plan without = plan(graph);
  BOOST_TEST(!has(without, "a"));
  BOOST_TEST(!has(without, "b"));
  BOOST_TEST(why(without, "node a") == "its outputs reach no sink and no recording");
  const Plan with = plan(graph + "  - a.out\n");
  BOOST_TEST(has(with, "a"));
  BOOST_TEST(!has(with, "b"));
}

BOOST_FIXTURE_TEST_CASE(writers_come_before_readers_and_cycles_break_at_what_does_not_trigger, Fixture) {
  // The file names the nodes from back to front.
  const std::string graph = R"(duration: 1 s
scene:
  bodies: {tool: {sphere: {radius: 1}, motion: rigid}, wall: {sphere: {radius: 1}}}
nodes:
  judge: {type: test.judge}
  hold: {type: test.hold}
  predictor: {type: test.predictor}
  coupling: {type: test.coupling, stiffness: 1}
  dynamics: {type: test.dynamics}
  collision: {type: test.collision}
  device: {type: test.device}
edges:
  - hold.segment -> device.segment
  - predictor.forecast -> hold.forecast
  - coupling.force -> predictor.force
  - dynamics.state -> coupling.state
  - collision.contacts -> dynamics.contacts
  - dynamics.state -> collision.state
  - coupling.parameters -> dynamics.coupling
  - device.state -> collision.device
  - device.state -> dynamics.device
  - device.commanded -> judge.commanded
)";
  const Plan p = plan(graph);
  const std::vector<std::string> expected{"device", "judge", "collision", "dynamics", "coupling", "predictor", "hold"};
  BOOST_TEST(names(p) == expected, boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(inside_a_loop_a_writer_still_comes_before_a_reader_it_does_not_trigger, Fixture) {
  // The device closes a loop around everything; the refitter's coefficients are to be there when the predictor steps.
  const Plan p = plan(pipeline(rigid_scene));
  BOOST_TEST(position(p, "refit") < position(p, "predictor"));
}

BOOST_FIXTURE_TEST_CASE(nodes_without_an_order_keep_that_of_the_file, Fixture) {
  const Plan p =
      plan("duration: 1 s\nnodes:\n  c: {type: test.values}\n  a: {type: test.values}\n  b: {type: test.values}\n");
  BOOST_TEST(names(p) == (std::vector<std::string>{"c", "a", "b"}), boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(a_delay_opens_a_cycle_of_triggers, Fixture) {
  const std::string graph =
      "duration: 1 s\nnodes:\n  b: {type: test.gate}\n  a: {type: test.gate}\n  judge: {type: test.judge}\nedges:\n"
      "  - a.out -> b.in\n  - b.out -> a.in: {delay: 1 ms}\n  - b.out -> judge.commanded\n";
  const Plan p = plan(graph);
  BOOST_TEST(position(p, "a") < position(p, "b"));
  BOOST_TEST(position(p, "b") < position(p, "judge"));
  BOOST_CHECK_THROW(plan(replaced(graph, ": {delay: 1 ms}", "")), GraphError);
}

BOOST_FIXTURE_TEST_CASE(the_reference_run_holds_what_the_judge_compares_with_and_costs_nothing, Fixture) {
  const Plan judged = plan(pipeline(rigid_scene));
  const Plan reference = make_reference_plan(judged);
  BOOST_TEST(reference.streams.empty());
  BOOST_TEST(edge(reference, "device.commanded -> judge.commanded") == nullptr);
  BOOST_TEST_REQUIRE(edge(reference, "coupling.force -> judge.force") != nullptr);
  // Everything upstream of the force is there, through the loop of the device too.
  for (const char* name : {"device", "collision", "dynamics", "coupling", "predictor", "refit", "hold", "judge"}) {
    BOOST_TEST(has(reference, name));
  }
  for (const NodeSpec& node : reference.nodes) BOOST_TEST((node.cost.kind == CostModel::Kind::none));
  const NodeSpec& device = reference.nodes[position(reference, "device")];
  BOOST_TEST(std::get<double>(device.params[0]) == 10000.0);
  BOOST_TEST(std::get<double>(device.params[1]) == 0.0);
  BOOST_TEST((reference.graph.clock == Clock::virtual_));
  BOOST_TEST(reference.torque);
  // What was judged stays as it was.
  BOOST_TEST(std::get<double>(judged.nodes[position(judged, "device")].params[0]) == 1000.0);
}

BOOST_FIXTURE_TEST_CASE(the_reference_run_leaves_out_what_is_not_upstream, Fixture) {
  std::string graph = pipeline(rigid_scene);
  graph = replaced(graph, "  - hold.segment -> device.segment\n", "");
  graph = replaced(graph, "record:\n", "record:\n  - hold.segment\n");
  const Plan judged = plan(graph);
  BOOST_TEST(has(judged, "hold"));
  const Plan reference = make_reference_plan(judged);
  for (const char* name : {"predictor", "refit", "hold"}) BOOST_TEST(!has(reference, name));
  for (const char* name : {"device", "collision", "dynamics", "coupling", "judge"}) BOOST_TEST(has(reference, name));
}

BOOST_FIXTURE_TEST_CASE(there_is_no_reference_run_without_a_judge_that_asks, Fixture) {
  std::string graph = pipeline(rigid_scene);
  graph = replaced(graph, "  - coupling.force -> judge.force\n", "");
  BOOST_TEST(make_reference_plan(plan(graph)).nodes.empty());
}

BOOST_FIXTURE_TEST_CASE(explain_names_nodes_queues_and_what_is_left_out, Fixture) {
  const std::string text = explain(plan(pipeline(sliding_scene), {"predictor.adaptive=false"}), 200);
  for (const char* line :
       {"clock virtual, duration 1 s, seed 1, translation-only", "at 1000 Hz", "6 ms + 500 us a contact, jitter 10 %",
        "queue(4096, drop_oldest) (default)", "coupling.force", "the coefficients are fixed", "left out",
        "its outputs reach no sink and no recording"}) {
    BOOST_TEST(text.find(line) != std::string::npos, "not in the text: " << line << "\n" << text);
  }
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; ++at) {
    BOOST_TEST((at == 0 || text[at - 1] != ' '));
  }
}

BOOST_FIXTURE_TEST_CASE(diagrams_hold_every_node_and_edge, Fixture) {
  const Plan p = plan(pipeline(rigid_scene));
  const std::string mermaid = to_diagram(p, DiagramFormat::mermaid);
  const std::string dot = to_diagram(p, DiagramFormat::dot);
  BOOST_TEST(mermaid.starts_with("flowchart LR\n"));
  BOOST_TEST(dot.starts_with("digraph"));
  // A head line, one line a node and one an edge; dot has two more at the front and a brace.
  const auto lines = [](const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  };
  BOOST_TEST(lines(mermaid) == 1 + p.nodes.size() + p.edges.size());
  BOOST_TEST(lines(dot) == 4 + p.nodes.size() + p.edges.size());
  BOOST_TEST(mermaid.find("|\"contacts<br/>latest\"|") != std::string::npos);
  BOOST_TEST(dot.find("\"coupling\" -> \"refit\" [label=\"force\\nqueue(512, drop_oldest)\"]") != std::string::npos);
  BOOST_TEST(dot.find("\"hold\" -> \"device\" [label=\"segment\\nlatest\", style=dashed]") != std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
