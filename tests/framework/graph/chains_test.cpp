// Which nodes of the real-time lane share a loop.
#include "framework/graph/chains.hpp"

#include <boost/test/unit_test.hpp>

#include "tests/framework/engine/live/live_nodes.hpp"
#include "tests/framework/engine/sample_nodes.hpp"

BOOST_AUTO_TEST_SUITE(chains_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

using Groups = std::vector<std::vector<std::size_t>>;

/// A filter before a device, in the order of the plan; the edges are the test's.
struct Fixture {
  NodeInfo actor = Actor::declare();
  NodeInfo filters = Filter::declare();
  NodeInfo keeper = Keep::declare();
  PlanBuilder b{1.0};
  std::size_t stage = b.node("stage", filters, filter(), in_loop);
  std::size_t device = b.node("device", actor, {1000.0}, in_loop);

  std::size_t add(const std::string& name, const Scheduling& scheduling = in_loop, double rate = 1000) {
    return b.node(name, filters, filter(rate), scheduling);
  }
  void connect(std::size_t from, std::size_t to, Queue queue = {}, Duration delay = {}) {
    b.edge(from, to, 0, queue, false, delay);
  }
  void check(const Groups& nodes, const std::vector<bool>& inner) const {
    const Chains chains = find_chains(b.plan);
    BOOST_TEST((chains.nodes == nodes));
    BOOST_TEST((chains.inner == inner));
    for (std::size_t c = 0; c < chains.nodes.size(); ++c) {
      for (const std::size_t n : chains.nodes[c]) BOOST_TEST((chains.of[n] == c));
    }
  }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(nodes_that_feed_each_other_share_a_loop_and_the_device_steps_first, Fixture) {
  connect(stage, device);
  connect(device, stage);
  check({{device, stage}}, {true, true});
}

BOOST_FIXTURE_TEST_CASE(a_chain_goes_on_over_further_nodes_in_the_order_of_the_plan, Fixture) {
  const auto second = add("second"), last = add("last"), alone = add("alone");
  connect(last, stage);
  connect(device, second);
  connect(second, last);
  check({{device, stage, second, last}, {alone}}, {true, true, true});
}

BOOST_FIXTURE_TEST_CASE(two_devices_without_an_edge_have_a_loop_each, Fixture) {
  const auto other = b.node("other", actor, {1000.0}, in_loop);
  connect(stage, other);
  check({{other, stage}, {device}}, {true});
}

BOOST_FIXTURE_TEST_CASE(two_devices_that_a_stage_joins_do_not_wait_for_one_another, Fixture) {
  const auto other = b.node("other", actor, {1000.0}, in_loop);
  connect(device, stage);
  connect(stage, other);
  connect(stage, device);
  check({{device, stage}, {other}}, {true, false, true});
}

BOOST_FIXTURE_TEST_CASE(another_rate_priority_policy_or_core_has_a_loop_of_its_own, Fixture) {
  using enum SchedulingPolicy;
  const auto slow = add("slow", in_loop, 500), fast = add("fast", {Lane::realtime, "", fifo, 80, {}}),
             faster = add("faster", {Lane::realtime, "", fifo, 81, {}}),
             pinned = add("pinned", {Lane::realtime, "", fifo, 80, 1});
  for (const auto n : {slow, fast, faster, pinned}) connect(n, device);
  connect(fast, faster);
  connect(fast, pinned);
  check({{stage}, {device}, {slow}, {fast}, {faster}, {pinned}}, std::vector<bool>(6, false));
}

BOOST_FIXTURE_TEST_CASE(nodes_of_other_lanes_are_in_no_chain, Fixture) {
  const auto pool = add("pool", {}), thread = add("thread", {Lane::thread, "", {}, {}, {}});
  connect(pool, device);
  connect(pool, thread);
  connect(stage, pool);
  check({{stage}, {device}}, {false, false, false});
  const Chains chains = find_chains(b.plan);
  BOOST_TEST(!chains.of[pool].has_value());
  BOOST_TEST(!chains.of[thread].has_value());
}

BOOST_FIXTURE_TEST_CASE(what_cannot_be_passed_on_within_the_tick_joins_no_nodes, Fixture) {
  const auto sink = b.node("sink", keeper, {}, in_loop);
  connect(stage, device, {}, Duration{1'000'000});
  connect(device, stage, {QueuePolicy::block, 2});
  connect(stage, stage);
  connect(stage, sink);
  check({{stage}, {device}, {sink}}, {false, false, false, false});
  // Of nodes that another edge joins it goes by the engine.
  connect(stage, device);
  check({{device, stage}, {sink}}, {false, false, false, false, true});
}

BOOST_FIXTURE_TEST_CASE(explain_and_diagrams_show_the_chains_of_a_live_run, Fixture) {
  connect(stage, device);
  static_cast<void>(add("alone"));
  const std::string line = "in one real-time loop, stepping in this order: device, stage\n";
  const std::string in_mermaid = "  subgraph loop0[\"one loop\"]\n    n1\n    n0\n  end\n",
                    in_dot =
                        "  subgraph \"cluster_0\" {\n    label=\"one loop\";\n    \"device\";\n    "
                        "\"stage\";\n  }\n";
  for (const Clock clock : {Clock::real, Clock::virtual_}) {
    b.plan.graph.clock = clock;
    const auto has = [](const std::string& text, const std::string& part) {
      return text.find(part) != std::string::npos;
    };
    BOOST_TEST(has(explain(b.plan, 200), line) == (clock == Clock::real));
    BOOST_TEST(has(to_diagram(b.plan, DiagramFormat::mermaid), in_mermaid) == (clock == Clock::real));
    BOOST_TEST(has(to_diagram(b.plan, DiagramFormat::dot), in_dot) == (clock == Clock::real));
    BOOST_TEST(!has(to_diagram(b.plan, DiagramFormat::dot), "cluster_1"));
  }
}

BOOST_AUTO_TEST_SUITE_END()
