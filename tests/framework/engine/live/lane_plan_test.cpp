// Which threads a plan gets.
#include "framework/engine/live/lane_plan.hpp"

#include <boost/test/unit_test.hpp>
#include <numeric>

#include "framework/core/check.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"

BOOST_AUTO_TEST_SUITE(lane_plan_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

/// The lanes on a machine all of whose cores may be used.
LanePlan on_cores(const Plan& plan, int cores) {
  std::vector<int> all(static_cast<std::size_t>(cores));
  std::iota(all.begin(), all.end(), 0);
  return plan_lanes(plan, cores, all, true);
}

struct Fixture {
  NodeInfo worker = Worker::declare();
  NodeInfo actor = Actor::declare();
  PlanBuilder b{1.0};
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(nodes_that_name_a_thread_share_it_and_others_have_their_own, Fixture) {
  b.node("a", worker, {0.0}, {Lane::thread, "physics", SchedulingPolicy::fifo, 40, {}});
  b.node("b", worker, {0.0}, {Lane::thread, "physics", {}, {}, 0});
  b.node("c", worker, {0.0}, {Lane::thread, "", {}, {}, {}});
  b.node("d", worker, {0.0});
  const LanePlan lanes = on_cores(b.plan, 2);
  BOOST_REQUIRE(lanes.lanes.size() == 3U);
  BOOST_TEST(lanes.lanes[0].name == "pool");
  BOOST_TEST(lanes.lanes[1].name == "physics");
  BOOST_TEST(lanes.lanes[2].name == "c");
  const ThreadSettings both{SchedulingPolicy::fifo, 40, 0};
  BOOST_TEST((lanes.lanes[1].settings == both));
  const std::vector<std::size_t> of{1, 1, 2, 0};
  BOOST_TEST(lanes.lane_of == of, boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(the_pool_has_one_worker_a_node_and_at_most_one_a_core_unless_told, Fixture) {
  BOOST_TEST(on_cores(b.plan, 4).lanes[0].workers == 1);
  for (const char* name : {"a", "b", "c"}) b.node(name, worker, {0.0});
  BOOST_TEST(on_cores(b.plan, 4).lanes[0].workers == 3);
  BOOST_TEST(on_cores(b.plan, 2).lanes[0].workers == 2);
  b.plan.graph.live.pool_workers = 7;
  BOOST_TEST(on_cores(b.plan, 2).lanes[0].workers == 7);
}

BOOST_FIXTURE_TEST_CASE(a_device_is_pinned_to_the_last_core_where_there_are_several, Fixture) {
  b.node("device", actor, {1000.0}, {Lane::realtime, "", {}, {}, {}});
  const ThreadSettings pinned{SchedulingPolicy::fifo, 80, 3};
  BOOST_TEST((*on_cores(b.plan, 4).realtime[0] == pinned));
  BOOST_TEST(!on_cores(b.plan, 1).realtime[0]->cpu.has_value());
  b.plan.nodes[0].scheduling = {Lane::realtime, "", SchedulingPolicy::other, {}, 0};
  const ThreadSettings asked{SchedulingPolicy::other, 0, 0};
  BOOST_TEST((*on_cores(b.plan, 4).realtime[0] == asked));
}

BOOST_FIXTURE_TEST_CASE(a_core_that_is_not_there_is_an_error_that_names_the_node, Fixture) {
  b.node("heavy", worker, {0.0}, {Lane::thread, "", {}, {}, 2});
  BOOST_CHECK_EXCEPTION(on_cores(b.plan, 2), InputError, [](const InputError& e) {
    return std::string(e.what()).find("nodes.heavy: cpu: expected a core of this machine, 0 to 1, found 2") !=
           std::string::npos;
  });
}

BOOST_FIXTURE_TEST_CASE(cores_that_the_process_may_not_use_are_not_asked_for, Fixture) {
  b.node("device", actor, {1000.0}, {Lane::realtime, "", {}, {}, {}});
  for (const char* name : {"a", "b", "c"}) b.node(name, worker, {0.0});
  const LanePlan of_two = plan_lanes(b.plan, 8, {2, 5}, true);
  BOOST_TEST((of_two.realtime[0]->cpu == 5));
  BOOST_TEST(of_two.lanes[0].workers == 2);
  const LanePlan of_one = plan_lanes(b.plan, 8, {0}, true);
  BOOST_TEST(!of_one.realtime[0]->cpu.has_value());
  BOOST_TEST(of_one.lanes[0].workers == 1);
}

BOOST_FIXTURE_TEST_CASE(a_device_without_real_time_is_pinned_only_where_the_graph_says_so, Fixture) {
  b.node("device", actor, {1000.0}, {Lane::realtime, "", {}, {}, {}});
  BOOST_TEST(!plan_lanes(b.plan, 4, {0, 1, 2, 3}, false).realtime[0]->cpu.has_value());
  b.plan.nodes[0].scheduling.cpu = 2;
  BOOST_TEST((plan_lanes(b.plan, 4, {0, 1, 2, 3}, false).realtime[0]->cpu == 2));
}

BOOST_AUTO_TEST_SUITE_END()
