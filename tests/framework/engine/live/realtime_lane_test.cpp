// A loop of the real-time lane with several nodes: their order, what they see of each other, and their metrics.
#include "framework/engine/live/realtime_lane.hpp"

#include <boost/test/unit_test.hpp>
#include <chrono>
#include <thread>

#include "framework/realtime/allocation_watch.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"

BOOST_AUTO_TEST_SUITE(realtime_lane_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

/// The first chain of a plan in a lane without an engine. What it sends is published after the run, which is short
/// enough for its ring.
struct LaneRun final : ExternalInputs {
  explicit LaneRun(const Plan& plan)
      : nodes(plan), chains(find_chains(plan)), dispatcher(nodes, chains, this), lane(nodes, chains, 0, {}) {}

  void on_arrival(std::size_t /*edge*/, const Stamp& /*stamp*/, const void* /*payload*/) override { ++arrived; }
  void on_phase(Phase /*phase*/) override {}

  void run() {
    dispatcher.start();
    lane.count_from(dispatcher);
    lane.set_phase(Phase::running);
    static_cast<void>(lane.start(MonotonicClock::now() + Duration{5'000'000}));
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    BOOST_REQUIRE(lane.stop(Duration{1'000'000'000}));
    while (lane.take_tick()) {
      events.push_back(lane.event());
      deadlines.push_back(lane.deadline());
      for (const RealtimeLane::Out& out : lane.sent()) dispatcher.publish(out.node, out.port, out.valid, out.payload);
    }
    BOOST_TEST(lane.dropped_out() == 0U);
  }
  [[nodiscard]] std::size_t ticks() const { return static_cast<std::size_t>(lane.loop().metrics().ended.value()); }
  const Filter& filter_at(std::size_t n) { return dynamic_cast<const Filter&>(nodes[n]); }
  const Actor& actor_at(std::size_t n) { return dynamic_cast<const Actor&>(nodes[n]); }

  PlanNodes nodes;
  Chains chains;
  Dispatcher dispatcher;
  RealtimeLane lane;
  int arrived = 0;
  std::vector<TickEvent> events;
  std::vector<Time> deadlines;
};

/// Two stages before a device, of which none is in the order of stepping.
struct Fixture {
  NodeInfo actor = Actor::declare();
  NodeInfo filters = Filter::declare();
  PlanBuilder b{1.0};
  std::size_t first = b.node("first", filters, filter(), in_loop);
  std::size_t second = b.node("second", filters, filter(1000, 2), in_loop);
  std::size_t device = b.node("device", actor, {1000.0}, in_loop);
  std::size_t to_first = b.edge(device, first, 0, {}, false);
  std::size_t to_second = b.edge(first, second, 0, {}, false);
  std::size_t to_device = b.edge(second, device, 0, {}, false);
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_tick_steps_the_device_and_then_the_others_and_each_sees_what_was_sent_before_it, Fixture) {
  LaneRun run(b.plan);
  run.run();
  BOOST_REQUIRE(run.ticks() > 5U);
  BOOST_REQUIRE(run.events.size() == 3 * run.ticks());
  const std::size_t order[] = {device, first, second};
  for (std::size_t i = 0; i < run.events.size(); ++i) {
    BOOST_TEST(static_cast<std::size_t>(run.events[i].node) == order[i % 3]);
    BOOST_TEST(run.events[i].tick == run.events[i / 3 * 3].tick);
    BOOST_TEST((run.deadlines[i] == run.deadlines[i / 3 * 3]));
    // The device sees what the last sent in the tick before.
    BOOST_TEST(run.events[i].inputs == 1);
    BOOST_TEST(run.events[i].seen[0] == i / 3 + (i % 3 == 0 ? 0 : 1));
  }
  const auto& shown = run.actor_at(device).seen;
  for (std::size_t i = 0; i < run.ticks(); ++i) {
    for (const std::size_t n : {first, second}) {
      const Filter::Seen& seen = run.filter_at(n).seen[i];
      BOOST_TEST((seen.now == shown[i].now));
      BOOST_TEST((seen.stamp.valid == seen.now));
      BOOST_TEST((seen.stamp.produced == seen.now));
      BOOST_TEST(seen.stamp.sequence == i);
      BOOST_TEST(seen.value == static_cast<double>(i));
    }
    BOOST_TEST(shown[i].any == (i > 0));
    if (i == 0) continue;
    BOOST_TEST((shown[i].produced == shown[i - 1].now));
    BOOST_TEST(shown[i].value == 2 * static_cast<double>(i - 1));
  }
}

BOOST_FIXTURE_TEST_CASE(messages_of_inner_edges_are_counted_once_and_never_arrive_a_second_time, Fixture) {
  LaneRun run(b.plan);
  Tap tap(message_type<Wrench>(), {QueuePolicy::drop_newest, 1000});
  run.dispatcher.add_tap(first, 0, tap);
  run.run();
  BOOST_TEST(run.arrived == 0);
  for (const std::size_t edge : {to_first, to_second, to_device}) {
    const EdgeStatistics statistics = run.dispatcher.edge_statistics(edge);
    BOOST_TEST(statistics.delivered == run.ticks());
    BOOST_TEST(statistics.dropped == 0U);
    BOOST_TEST(statistics.superseded == 0U);
  }
  std::uint64_t tapped = 0;
  while (const MessageView message = tap.take()) BOOST_TEST(message.stamp->sequence == tapped++);
  BOOST_TEST(tapped == run.ticks());
  BOOST_TEST(run.lane[first].age(to_first)->max().ns == 0);
  BOOST_TEST(run.lane[second].age(to_second)->max().ns == 0);
  BOOST_TEST(run.lane[device].age(to_device)->count() == run.ticks() - 1);
  BOOST_TEST(run.lane[device].age(to_device)->max().ns >= 1'000'000);
  BOOST_TEST(run.lane[device].age(to_first) == nullptr);
}

BOOST_FIXTURE_TEST_CASE(a_full_queue_of_an_inner_edge_goes_by_its_policy_and_counts, Fixture) {
  // Nobody takes from it.
  b.plan.edges[to_second].spec.queue = {QueuePolicy::drop_oldest, 4};
  LaneRun run(b.plan);
  run.run();
  const EdgeStatistics statistics = run.dispatcher.edge_statistics(to_second);
  BOOST_TEST(statistics.delivered == run.ticks());
  BOOST_TEST(statistics.dropped == run.ticks() - 4);
  BOOST_TEST(run.filter_at(second).seen.back().stamp.sequence == run.ticks() - 1);
}

BOOST_FIXTURE_TEST_CASE(a_node_alone_has_a_lane_as_before_and_sees_what_the_engine_puts_in, Fixture) {
  b.plan.nodes[first].scheduling.cpu = 0;
  LaneRun run(b.plan);
  const Wrench w{{5, 0, 0}, {}};
  run.lane[first].put(to_first, {{}, {}, 0}, &w);
  run.run();
  BOOST_TEST(run.events.size() == run.ticks());
  BOOST_TEST(run.filter_at(first).seen.front().value == 5);
  BOOST_TEST(run.actor_at(device).seen.empty());
  BOOST_TEST(run.arrived == static_cast<int>(run.ticks()));
}

BOOST_FIXTURE_TEST_CASE(a_middle_node_that_throws_is_left_out_and_the_others_go_on, Fixture) {
  b.plan.nodes[first].params = filter(1000, 1, 5);
  LaneRun run(b.plan);
  run.run();
  BOOST_REQUIRE(run.ticks() > 10U);
  BOOST_TEST(run.filter_at(first).seen.size() == 5U);
  BOOST_TEST(run.filter_at(second).seen.size() == run.ticks());
  BOOST_TEST(run.actor_at(device).seen.size() == run.ticks());
  BOOST_TEST(run.filter_at(second).seen.back().stamp.sequence == 3U);
  BOOST_TEST(run.events.size() == 3 * run.ticks() - (run.ticks() - 4));
  BOOST_TEST((run.lane.failure(device) == nullptr));
  BOOST_TEST((run.lane.failure(second) == nullptr));
  BOOST_REQUIRE((run.lane.failure(first) != nullptr));
  BOOST_CHECK_EXCEPTION(std::rethrow_exception(run.lane.failure(first)), RunError, [](const RunError& error) {
    return std::string(error.what()).starts_with("node first failed at ");
  });
}

BOOST_FIXTURE_TEST_CASE(the_loop_ends_with_its_last_node, Fixture) {
  b.plan.edges.clear();
  b.plan.nodes[first].params = filter(1000, 1, 5);
  b.plan.nodes[second].params = filter(1000, 1, 8);
  b.edge(first, second, 0, {}, false);
  LaneRun run(b.plan);
  run.run();
  BOOST_TEST(!run.lane.loop().running());
  BOOST_TEST(run.filter_at(first).seen.size() == 5U);
  BOOST_TEST(run.filter_at(second).seen.size() == 8U);
  const auto node_of = [&](std::size_t n) {
    try {
      std::rethrow_exception(run.lane.failure(n));
    } catch (const RunError& error) {
      return std::string(error.what()).substr(0, 16);
    }
  };
  BOOST_TEST(node_of(first) == "node first faile");
  BOOST_TEST(node_of(second) == "node second fail");
}

BOOST_FIXTURE_TEST_CASE(each_node_of_a_chain_is_tuned_by_itself, Fixture) {
  LaneRun run(b.plan);
  BOOST_TEST(run.lane[first].is_tuned());
  BOOST_TEST(run.lane[first].tune(std::make_shared<const Filter::Params>(Filter::Params{.gain = 10})));
  BOOST_TEST(!run.lane[first].is_tuned());
  BOOST_TEST(run.lane[second].is_tuned());
  run.run();
  BOOST_TEST(run.lane[first].is_tuned());
  for (const TickEvent& event : run.events) {
    BOOST_TEST(event.sets == (static_cast<std::size_t>(event.node) == first ? 1U : 0U));
  }
  BOOST_TEST(run.filter_at(second).seen.at(3).value == 30);
  BOOST_TEST(run.actor_at(device).seen.at(4).value == 60);
}

BOOST_FIXTURE_TEST_CASE(the_time_of_a_tick_is_told_by_node, Fixture) {
  b.plan.nodes[second].params = filter(1000, 1, 3, 0.02);
  LaneRun run(b.plan);
  run.run();
  for (const std::size_t n : {device, first, second}) {
    BOOST_TEST(run.lane[n].body_time().count() == run.ticks());
    BOOST_TEST((run.lane[n].body_sum() >= run.lane[n].body_time().max()));
  }
  BOOST_TEST(run.lane[second].body_time().max().ns >= 20'000'000);
  BOOST_TEST(run.lane.loop().metrics().body_time.max().ns >= 20'000'000);
  const Duration sum = run.lane[device].body_sum() + run.lane[first].body_sum() + run.lane[second].body_sum();
  BOOST_TEST(sum.ns <= run.lane.loop().metrics().body_ns.value());
  if (heap_calls_are_counted()) BOOST_TEST(run.lane.loop().metrics().heap_calls.value() == 0);
}

BOOST_AUTO_TEST_SUITE_END()
