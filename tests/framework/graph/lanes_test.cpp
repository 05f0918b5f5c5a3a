// Lanes, threads and live settings: what node types and graphs say of them, and how files lay them over one another.
#include <boost/test/unit_test.hpp>

#include "framework/graph/plan.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(lanes_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

Scheduling on_thread(std::string thread, SchedulingPolicy policy, std::optional<int> priority = {},
                     std::optional<int> cpu = {}) {
  return {Lane::thread, std::move(thread), policy, priority, cpu};
}

Scheduling realtime(SchedulingPolicy policy, std::optional<int> priority, std::optional<int> cpu = {}) {
  return {Lane::realtime, "", policy, priority, cpu};
}

constexpr auto other = SchedulingPolicy::other;
constexpr auto fifo = SchedulingPolicy::fifo;
constexpr auto round_robin = SchedulingPolicy::round_robin;

struct Fixture {
  Folder folder;

  GraphSpec load(const std::string& text, const std::vector<std::string>& set = {}) {
    return load_text(folder, text, settings(set));
  }
  // The scheduling of the node v with these keys.
  Scheduling of(const std::string& keys, const std::vector<std::string>& set = {}) {
    return load("duration: 1 s\nnodes:\n  v: {" + keys + "}\n", set).node("v")->scheduling;
  }
  // The same where another file gives v the first keys and this one lays the second over them.
  Scheduling over(const std::string& base, const std::string& keys) {
    static_cast<void>(folder.write("base.yaml", "duration: 1 s\nnodes:\n  v: {" + base + "}\n"));
    return load("extends: base.yaml\nnodes:\n  v: {" + keys + "}\n").node("v")->scheduling;
  }
  LiveSettings live(const std::string& text, const std::vector<std::string>& set = {}) {
    return load("duration: 1 s\n" + text + "nodes: {v: {type: test.values}}\n", set).live;
  }
};

const std::string three_solvers = R"(duration: 1 s
nodes:
  a: {type: test.solver}
  b: {type: test.solver, policy: fifo}
  c: {type: test.values, lane: thread, thread: physics, cpu: 1}
  d: {type: test.values, lane: thread}
)";

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_node_steps_where_its_type_says, Fixture) {
  BOOST_TEST((of("type: test.values") == Scheduling{}));
  BOOST_TEST((of("type: test.solver") == on_thread("physics", other)));
  BOOST_TEST((of("type: test.motor") == realtime(fifo, 80)));
  // Being fit for the realtime lane does not put a type into it.
  BOOST_TEST((of("type: test.device") == Scheduling{}));
}

BOOST_FIXTURE_TEST_CASE(the_graph_says_it_otherwise, Fixture) {
  BOOST_TEST((of("type: test.solver, lane: pool") == Scheduling{}));
  BOOST_TEST((of("type: test.motor, lane: pool") == Scheduling{}));
  BOOST_TEST((of("type: test.values, lane: thread") == on_thread("", other)));
  BOOST_TEST((of("type: test.motor, lane: thread") == on_thread("", other)));
  BOOST_TEST((of("type: test.solver, lane: thread") == on_thread("physics", other)));
  BOOST_TEST((of("type: test.solver, thread: mine") == on_thread("mine", other)));
  BOOST_TEST((of("type: test.device, lane: realtime") == realtime(fifo, 80)));
  BOOST_TEST((of("type: test.motor, policy: round_robin, cpu: 1") == realtime(round_robin, 80, 1)));
  BOOST_TEST((of("type: test.motor, priority: 99") == realtime(fifo, 99)));
  BOOST_TEST((of("type: test.motor, policy: other") == realtime(other, std::nullopt)));
}

BOOST_FIXTURE_TEST_CASE(a_thread_with_a_realtime_policy_and_no_priority_runs_below_the_pool, Fixture) {
  const Scheduling scheduling = of("type: test.values, lane: thread, policy: fifo");
  BOOST_TEST((scheduling == on_thread("", fifo, 40)));
  BOOST_TEST(*scheduling.priority < LiveSettings{}.pool.priority);
}

BOOST_FIXTURE_TEST_CASE(nodes_of_one_thread_follow_those_that_say_something, Fixture) {
  const GraphSpec spec = load(three_solvers);
  for (const char* node : {"a", "b", "c"}) {
    BOOST_TEST((spec.node(node)->scheduling == on_thread("physics", fifo, 40, 1)), node);
  }
  BOOST_TEST((spec.node("d")->scheduling == on_thread("", other)));
  // The order in which they say it does not count, and saying the same twice is no error.
  const GraphSpec more = load(three_solvers, {"a.priority=33", "c.priority=33"});
  for (const char* node : {"a", "b", "c"}) BOOST_TEST(more.node(node)->scheduling.priority.value() == 33, node);
}

BOOST_FIXTURE_TEST_CASE(two_nodes_with_threads_of_their_own_need_not_agree, Fixture) {
  const GraphSpec spec = load(
      "duration: 1 s\nnodes:\n  a: {type: test.values, lane: thread, cpu: 0}\n"
      "  b: {type: test.values, lane: thread, cpu: 1}\n  c: {type: test.motor, cpu: 0}\n  d: {type: test.motor}\n");
  BOOST_TEST(spec.node("a")->scheduling.cpu.value() == 0);
  BOOST_TEST(spec.node("b")->scheduling.cpu.value() == 1);
  BOOST_TEST(!spec.node("d")->scheduling.cpu.has_value());
}

BOOST_FIXTURE_TEST_CASE(the_command_line_sets_lanes_and_says_where_it_is_wrong, Fixture) {
  BOOST_TEST((of("type: test.values", {"v.lane=thread", "v.thread=mine", "v.policy=fifo", "v.priority=7"}) ==
              on_thread("mine", fifo, 7)));
  BOOST_TEST((of("type: test.motor, priority: 90", {"v.lane=pool"}) == Scheduling{}));
  const auto error = [&](const std::vector<std::string>& set) {
    return errors_of(folder, three_solvers, settings(set));
  };
  BOOST_TEST(
      error({"a.lane=realtime"})
          .starts_with("--set a.lane=realtime: nodes.a.lane: realtime expects a node type that steps at a rate"));
  const std::string file = (folder.path() / "graph.yaml").string();
  BOOST_TEST(error({"a.cpu=0"}) == file +
                                       ":5:62: nodes.c.cpu: expected 0, which nodes.a.cpu (--set a.cpu=0) says of "
                                       "the same thread physics, found 1");
}

BOOST_FIXTURE_TEST_CASE(an_extending_file_changes_only_the_keys_it_names, Fixture) {
  const std::string base = "type: test.values, lane: thread, thread: mine, policy: fifo, priority: 20, cpu: 1";
  BOOST_TEST((over(base, "cpu: 0") == on_thread("mine", fifo, 20, 0)));
  BOOST_TEST((over(base, "priority: 21") == on_thread("mine", fifo, 21, 1)));
  BOOST_TEST((over(base, "lane: thread, thread: yours") == on_thread("yours", fifo, 20, 1)));
}

BOOST_FIXTURE_TEST_CASE(another_lane_replaces_the_old_one_with_its_thread, Fixture) {
  const std::string base = "type: test.device, lane: thread, thread: mine, policy: round_robin, priority: 20, cpu: 1";
  BOOST_TEST((over(base, "lane: pool") == Scheduling{}));
  BOOST_TEST((over(base, "lane: realtime, cpu: 0") == realtime(fifo, 80, 0)));
  BOOST_TEST((over("type: test.motor, priority: 90", "lane: thread") == on_thread("", other)));
  BOOST_TEST((over(base, "policy: other") == on_thread("mine", other, {}, 1)));
}

BOOST_FIXTURE_TEST_CASE(a_node_of_another_type_takes_no_lane_over, Fixture) {
  BOOST_TEST((over("type: test.values, lane: thread, thread: mine", "type: test.motor") == realtime(fifo, 80)));
}

BOOST_FIXTURE_TEST_CASE(live_settings_have_defaults_and_reach_the_spec, Fixture) {
  BOOST_TEST((live("") == LiveSettings{}));
  BOOST_TEST((live("live: {}\n") == LiveSettings{}));
  BOOST_TEST((live("live: {on_missing_privilege: warn, on_stall: stop, stall_timeout: 0.5 s, "
                   "pool: {policy: fifo, priority: 50}}\n") == LiveSettings{}));
  const LiveSettings all = live(
      "live:\n  on_missing_privilege: fail\n  on_stall: recover\n  stall_timeout: 250 ms\n  impose_cost: true\n"
      "  pool: {workers: 64, policy: round_robin, priority: 99, cpu: 1}\n");
  BOOST_TEST((all.on_missing_privilege == OnMissingPrivilege::fail));
  BOOST_TEST((all.on_stall == OnStall::recover));
  BOOST_TEST(all.stall_timeout.ns == 250'000'000);
  BOOST_TEST(all.impose_cost);
  BOOST_TEST(all.pool_workers == 64);
  BOOST_TEST((all.pool == ThreadSettings{round_robin, 99, 1}));
  BOOST_TEST((live("live: {pool: {policy: other}}\n").pool == ThreadSettings{other, 0, std::nullopt}));
  BOOST_TEST((live("live: {pool: {policy: round_robin}}\n").pool == ThreadSettings{round_robin, 50, std::nullopt}));
}

BOOST_FIXTURE_TEST_CASE(live_settings_merge_key_by_key_and_can_be_set, Fixture) {
  const std::string text = "live: {on_stall: recover, pool: {workers: 2, priority: 60}}\n";
  const LiveSettings set = live(text, {"live.pool.workers=3", "live.stall_timeout=1 s"});
  BOOST_TEST((set.on_stall == OnStall::recover));
  BOOST_TEST(set.pool_workers == 3);
  BOOST_TEST(set.pool.priority == 60);
  BOOST_TEST(set.stall_timeout.ns == 1'000'000'000);
  static_cast<void>(folder.write("base.yaml", "duration: 1 s\n" + text + "nodes: {v: {type: test.values}}\n"));
  const LiveSettings merged = load("extends: base.yaml\nlive: {pool: {policy: other}}\n").live;
  BOOST_TEST((merged.on_stall == OnStall::recover));
  BOOST_TEST(merged.pool_workers == 2);
  BOOST_TEST((merged.pool == ThreadSettings{other, 0, std::nullopt}));
}

BOOST_FIXTURE_TEST_CASE(written_yaml_keeps_every_lane_and_setting, Fixture) {
  for (const char* head : {"", "live: {pool: {policy: other, cpu: 0}}\n",
                           "live: {on_stall: recover, pool: {workers: 1}}\n", "live: {impose_cost: true}\n"}) {
    const GraphSpec spec = load(head + three_solvers +
                                "  e: {type: test.motor, policy: other, cpu: 0}\n  f: {type: test.motor, lane: pool}\n"
                                "  g: {type: test.motor}\n  h: {type: test.solver, thread: mine, policy: other}\n");
    const GraphSpec again = load(to_yaml(spec));
    BOOST_TEST((again.live == spec.live));
    BOOST_TEST_REQUIRE(again.nodes.size() == spec.nodes.size());
    for (std::size_t i = 0; i < spec.nodes.size(); ++i) {
      BOOST_TEST((again.nodes[i].scheduling == spec.nodes[i].scheduling), spec.nodes[i].name);
    }
  }
}

BOOST_FIXTURE_TEST_CASE(an_edge_of_the_realtime_lane_may_block_under_the_virtual_clock, Fixture) {
  const std::string graph =
      "duration: 1 s\nnodes:\n  motor: {type: test.motor}\n  solver: {type: test.solver}\n"
      "edges:\n  - motor.state -> solver.device\n  - solver.force -> motor.force: queue(2, block)\n";
  BOOST_TEST(errors_of(folder, graph) == "");
  const std::string errors = errors_of(folder, graph, settings({"clock=real"}));
  BOOST_TEST(errors.find("found block (the default of solver); motor is in the realtime lane") != std::string::npos);
  BOOST_TEST(errors.find("found block; motor is in the realtime lane") != std::string::npos);
  // Off that lane a device may be waited for, and still waits for nobody.
  const std::string off = errors_of(folder, graph, settings({"clock=real", "motor.lane=thread"}));
  BOOST_TEST(off.find("found block (the default of solver); motor drives a device") != std::string::npos);
  BOOST_TEST(off.find("found block; ") == std::string::npos);
}

BOOST_FIXTURE_TEST_CASE(explain_tells_lanes_and_what_is_default, Fixture) {
  constexpr std::size_t wide = 200;  // columns, so that no line is folded
  const std::string graph =
      three_solvers +
      "  e: {type: test.motor}\n  f: {type: test.motor, cpu: 1}\n"
      "edges:\n  - e.state -> a.device: latest\n  - e.state -> b.device: latest\nrecord: [a.force, b.force]\n";
  const std::string text = explain(make_plan(load(graph, {"b.policy=other"})), wide);
  const auto row = [&](const std::string& node) {
    const std::size_t at = text.find("\n  " + node + " ");
    BOOST_REQUIRE(at != std::string::npos);
    return text.substr(at + 1, text.find('\n', at + 1) - at - 1);
  };
  BOOST_TEST(row("b").ends_with("  thread physics, other, cpu 1"));
  BOOST_TEST(row("d").ends_with("  own thread, other"));
  BOOST_TEST(row("e").ends_with("  realtime, fifo 80 (default)"));
  BOOST_TEST(row("f").ends_with("  realtime, fifo 80, cpu 1"));
  BOOST_TEST(text.find("pool:") == std::string::npos);
  const std::string live = explain(make_plan(load(graph, {"clock=real"})), wide);
  BOOST_TEST(live.find("pool: fifo 50; a missing privilege: warn; a step of more than 500 ms: stop (default)\n") !=
             std::string::npos);
  const std::string set =
      explain(make_plan(load(graph, {"clock=real", "live.pool.workers=1", "live.pool.cpu=0"})), wide);
  BOOST_TEST(set.find("pool: 1 worker, fifo 50, cpu 0; a missing privilege: warn;") != std::string::npos);
}

BOOST_FIXTURE_TEST_CASE(a_reference_run_has_no_lanes, Fixture) {
  const Plan reference =
      make_reference_plan(make_plan(load(pipeline(rigid_scene), {"collision.lane=thread", "device.lane=realtime"})));
  BOOST_TEST_REQUIRE(!reference.nodes.empty());
  for (const NodeSpec& node : reference.nodes) BOOST_TEST((node.scheduling == Scheduling{}), node.name);
}

BOOST_AUTO_TEST_SUITE_END()
