// The rate of the haptic loop is given once and reaches all of its nodes; another one is refused.
#include <boost/test/unit_test.hpp>

#include "framework/graph/plan.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(haptic_rate_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

// test.device and test.motor are nodes of the haptic loop, test.values has a rate of its own.
std::string graph(const std::string& key, const std::string& device, const std::string& motor) {
  return key + "duration: 1 s\nnodes:\n  device: {type: test.device" + device + "}\n  motor: {type: test.motor" +
         motor + "}\n  values: {type: test.values}\nrecord: [device.state]\n";
}

double rate(const GraphSpec& spec, const std::string& node) {
  const NodeSpec* found = spec.node(node);
  BOOST_REQUIRE(found != nullptr);
  return std::get<double>(found->params.at(found->info->rate_parameter.value()));
}

struct Fixture {
  Folder folder;

  void all_have(double expected, const GraphSpec& spec) const {
    BOOST_TEST(spec.rate == expected);
    BOOST_TEST(rate(spec, "device") == expected);
    BOOST_TEST(rate(spec, "motor") == expected);
    BOOST_TEST(rate(spec, "values") == 10.0);
  }
  std::string place() const { return (folder.path() / "graph.yaml").string(); }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_graph_that_gives_no_rate_has_1_kHz, Fixture) {
  all_have(1000, load_text(folder, graph("", "", "")));
}

BOOST_FIXTURE_TEST_CASE(the_rate_of_the_graph_reaches_every_node_of_the_haptic_loop_and_no_other, Fixture) {
  all_have(4000, load_text(folder, graph("rate: 4 kHz\n", "", "")));
}

BOOST_FIXTURE_TEST_CASE(the_rate_of_one_node_reaches_the_others, Fixture) {
  all_have(4000, load_text(folder, graph("", ", rate: 4 kHz", "")));
  all_have(2000, load_text(folder, graph("", "", ", rate: 2000")));
  // The same rate in other units is no other one.
  all_have(4000, load_text(folder, graph("rate: 4000\n", ", rate: 4 kHz", ", rate: 4e3 Hz")));
}

BOOST_FIXTURE_TEST_CASE(rates_that_differ_are_refused_with_both_places, Fixture) {
  const std::string remedy =
      "; all nodes of the haptic loop step at one rate: give it once, as the graph's rate, and take it out of the "
      "nodes";
  BOOST_TEST(errors_of(folder, graph("rate: 1 kHz\n", ", rate: 4 kHz", "")) ==
             place() + ":4:37: nodes.device.rate: expected 1 kHz as in rate (" + place() + ":1:7), found 4 kHz" +
                 remedy);
  BOOST_TEST(errors_of(folder, graph("", ", rate: 4 kHz", ", rate: 1000")) ==
             place() + ":4:35: nodes.motor.rate: expected 4 kHz as in nodes.device.rate (" + place() +
                 ":3:37), found 1000" + remedy);
}

BOOST_FIXTURE_TEST_CASE(a_rate_of_the_command_line_is_one_like_any_other, Fixture) {
  Overrides overrides{set_patch("rate=4 kHz")};
  all_have(4000, load_text(folder, graph("", "", ""), overrides));
  all_have(4000, load_text(folder, graph("rate: 1 kHz\n", "", ""), overrides));
  overrides = {set_patch("device.rate=4000")};
  all_have(4000, load_text(folder, graph("", "", ""), overrides));
  all_have(4000, load_text(folder, graph("", ", rate: 1 kHz", ""), overrides));
  const std::string found = errors_of(folder, graph("rate: 1 kHz\n", "", ""), overrides);
  BOOST_TEST(found.starts_with("--set device.rate=4000: nodes.device.rate: expected 1 kHz as in rate (" + place() +
                               ":1:7), found 4000; "),
             found);
}

BOOST_FIXTURE_TEST_CASE(check_explain_tells_the_rate_of_the_haptic_loop, Fixture) {
  const std::string text = explain(make_plan(load_text(folder, graph("rate: 4 kHz\n", "", ""))), 200);
  BOOST_TEST(text.find("nothing moves, haptic loop at 4000 Hz\n") != std::string::npos, text);
  BOOST_TEST(text.find("at 4000 Hz", text.find("motor")) != std::string::npos, text);
  const std::string none =
      explain(make_plan(load_text(folder, "duration: 1 s\nnodes: {values: {type: test.values}}\n")), 200);
  BOOST_TEST(none.find("haptic loop") == std::string::npos, none);
}

BOOST_FIXTURE_TEST_CASE(a_written_graph_gives_the_rate_once, Fixture) {
  const GraphSpec spec = load_text(folder, graph("", ", rate: 4 kHz", ""));
  const std::string text = to_yaml(spec);
  BOOST_TEST(text.find("\nrate: 4000\n") != std::string::npos, text);
  BOOST_TEST(text.find("\n    rate: 4000\n") == std::string::npos, text);
  all_have(4000, load_text(folder, text));
  // So that a graph which was written can be run at another rate.
  all_have(2000, load_text(folder, text, {set_patch("rate=2 kHz")}));
}

BOOST_FIXTURE_TEST_CASE(an_overlay_tells_another_rate_once, Fixture) {
  const GraphSpec from = load_text(folder, graph("", "", ""));
  const GraphSpec to = load_text(folder, graph("rate: 4 kHz\n", "", ""));
  const std::string text = to_overlay(from, to, "fast", {"base.yaml"});
  BOOST_TEST(text == "title: \"fast\"\nextends: [\"base.yaml\"]\nrate: 4000\n");
}

BOOST_FIXTURE_TEST_CASE(the_reference_run_of_a_node_has_the_rate_that_it_declares, Fixture) {
  const Plan plan = make_reference_plan(make_plan(load_text(folder, "rate: 4 kHz\n" + pipeline(rigid_scene))));
  BOOST_REQUIRE(!plan.nodes.empty());
  for (const NodeSpec& node : plan.nodes) {
    if (node.name != "device") continue;
    BOOST_TEST(std::get<double>(node.params.at(node.info->rate_parameter.value())) == 10000.0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
