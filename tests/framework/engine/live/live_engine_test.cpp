// Starting, stopping, failing and stalling of live runs, and what the real-time lane sees.

#include <boost/test/unit_test.hpp>
#include <map>
#include <memory>
#include <regex>

#include "tests/framework/engine/live/drive.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"
#include "tests/framework/engine/sample_nodes.hpp"

BOOST_AUTO_TEST_SUITE(live_engine_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// device -> worker (on a thread) -> device, and a keeper.
struct Loop {
  NodeInfo actor = Actor::declare();
  NodeInfo worker = Worker::declare();
  NodeInfo keep = Keep::declare();
  NodeInfo culprit = Culprit::declare();
  PlanBuilder b;

  explicit Loop(double duration_s, Lane lane = Lane::realtime) : b(duration_s) {
    const auto device = b.node("device", actor, {1000.0}, {lane, "", SchedulingPolicy::other, {}, {}});
    const auto physics = b.node("physics", worker, {0.01}, {Lane::thread, "physics", {}, {}, {}});
    const auto keeper = b.node("keeper", keep, {});
    b.edge(device, physics, 0, {}, true);
    b.edge(physics, device, 0, {}, false);
    b.edge(device, keeper, 0, {QueuePolicy::drop_oldest, 64}, true);
  }
  std::size_t add_culprit(const std::string& deed, std::int64_t when, double hang) {
    const auto n = b.node("culprit", culprit, {deed, when, hang});
    b.edge(0, n, 0, {}, true);
    return n;
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_tick_of_the_realtime_lane_sees_only_what_was_visible_by_its_deadline) {
  Loop loop(1.0);
  LiveEngine run(loop.b.plan);
  drive(run);
  BOOST_TEST(!run.failure().has_value());
  const auto& seen = dynamic_cast<const Actor&>(run.nodes()[0]).seen;
  BOOST_REQUIRE(seen.size() > 300U);
  std::size_t with_value = 0;
  for (const Actor::Seen& s : seen) {
    BOOST_REQUIRE(s.now.ns % 1'000'000 == 0);
    if (!s.any) continue;
    ++with_value;
    BOOST_REQUIRE(s.produced <= s.now);
  }
  BOOST_TEST(with_value > seen.size() / 2);
  for (std::size_t i = 1; i < seen.size(); ++i) BOOST_REQUIRE(seen[i].now > seen[i - 1].now);
}

BOOST_AUTO_TEST_CASE(devices_start_disengaged_and_are_told_to_stop_and_waited_for) {
  for (const Lane lane : {Lane::realtime, Lane::thread, Lane::pool}) {
    Loop loop(0.5, lane);
    LiveEngine run(loop.b.plan);
    drive(run);
    const auto& seen = dynamic_cast<const Actor&>(run.nodes()[0]).seen;
    std::map<Phase, int> ticks;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      ++ticks[seen[i].phase];
      if (i > 0) BOOST_REQUIRE(seen[i].phase >= seen[i - 1].phase);
      if (seen[i].phase == Phase::stopping) BOOST_REQUIRE(seen[i].now.seconds() >= 0.5 - 1e-9);
    }
    BOOST_TEST(ticks[Phase::starting] >= 1);
    BOOST_TEST(ticks[Phase::running] > 100);
    // It asked for 49 more.
    BOOST_TEST(ticks[Phase::stopping] >= 50);
    BOOST_TEST(seen.front().any == false);
  }
}

BOOST_AUTO_TEST_CASE(sinks_get_nothing_of_the_ramp_down) {
  Loop loop(0.3);
  LiveEngine run(loop.b.plan);
  drive(run);
  const auto& kept = dynamic_cast<const Keep&>(run.nodes()[2]).kept;
  BOOST_REQUIRE(kept.size() > 100U);
  for (const Keep::Entry& e : kept) BOOST_REQUIRE(e.stamp.produced.seconds() <= 0.3);
}

BOOST_AUTO_TEST_CASE(saying_no_ends_the_run_early_without_a_failure) {
  Loop loop(30);
  LiveEngine run(loop.b.plan);
  const auto begin = std::chrono::steady_clock::now();
  int asked = 0;
  drive(run, [&asked](const EngineStatus&) { return ++asked < 3; });
  BOOST_TEST(seconds_since(begin) < 10);
  BOOST_TEST(!run.failure().has_value());
  const EngineStatus end = run.status();
  BOOST_TEST(end.now.seconds() < 10);
  BOOST_REQUIRE(end.devices.size() == 1U);
  // The histograms are there at the end, whole; the loop goes on to count while they are read.
  std::uint64_t wakeups = 0;
  for (const auto& [middle, count] : end.devices[0].wake_latency.counts) wakeups += count;
  BOOST_TEST(wakeups > 0U);
  BOOST_TEST(wakeups >= end.devices[0].wake_latency.count);
}

BOOST_AUTO_TEST_CASE(a_node_that_throws_ends_the_run_with_its_name_and_lets_the_device_ramp_down) {
  Loop loop(30);
  loop.add_culprit("throws", 20, 0);
  LiveEngine run(loop.b.plan);
  drive(run);
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(run.failure()->find("culprit") != std::string::npos);
  BOOST_TEST(run.failure()->find("it broke") != std::string::npos);
  BOOST_TEST(!run.is_abandoned());
  BOOST_TEST((dynamic_cast<const Actor&>(run.nodes()[0]).seen.back().phase == Phase::stopping));
}

BOOST_AUTO_TEST_CASE(a_step_that_hangs_ends_the_run_with_its_name_while_the_device_goes_on) {
  Loop loop(30);
  loop.b.plan.graph.live.stall_timeout = Duration{200'000'000};
  loop.add_culprit("hangs", 20, 0.9);
  LiveEngine run(loop.b.plan);
  drive(run);
  BOOST_REQUIRE(run.failure().has_value());
  // In this order: which node, when the step began, and for how long it has not come back.
  BOOST_TEST(
      std::regex_search(
          *run.failure(),
          std::regex(
              R"(node culprit \(sample\.culprit\) has stalled: its step, begun [0-9.]+ m?s after the start of the )"
              R"(run, has not come back for [0-9.]+ m?s; live\.stall_timeout of the graph is 200 ms)")),
      *run.failure());
  BOOST_TEST(!run.is_abandoned());
  const auto& seen = dynamic_cast<const Actor&>(run.nodes()[0]).seen;
  BOOST_TEST((seen.back().phase == Phase::stopping));
}

BOOST_AUTO_TEST_CASE(a_stall_is_waited_out_where_the_graph_says_so) {
  Loop loop(2);
  loop.b.plan.graph.live.stall_timeout = Duration{200'000'000};
  loop.b.plan.graph.live.on_stall = OnStall::recover;
  const auto culprit = loop.add_culprit("hangs", 20, 0.9);
  LiveEngine run(loop.b.plan);
  bool seen_stalled = false;
  drive(run, [&](const EngineStatus& s) {
    seen_stalled = seen_stalled || s.nodes[culprit].stalled;
    return true;
  });
  BOOST_TEST(seen_stalled);
  BOOST_TEST(!run.failure().has_value());
  BOOST_TEST(!run.status().nodes[culprit].stalled);
  BOOST_TEST(run.status().nodes[culprit].steps > 20U);
}

BOOST_AUTO_TEST_CASE(a_node_whose_start_throws_keeps_the_run_from_beginning) {
  struct Refuses final : Node {
    struct Params {};
    Refuses(const Params&, const NodeContext&) {}
    static NodeInfo declare() { return Declare<Refuses>("sample.refuses", "Refuses.").info(); }
    void start(StepContext&) override { throw InputError("not today"); }
    void step(StepContext&) override {}
  };
  Loop loop(30);
  const NodeInfo info = Refuses::declare();
  loop.b.node("refuses", info, {});
  LiveEngine run(loop.b.plan);
  BOOST_CHECK_EXCEPTION(run.start(), InputError,
                        [](const InputError& e) { return std::string(e.what()) == "node refuses: not today"; });
  BOOST_TEST(dynamic_cast<const Actor&>(run.nodes()[0]).seen.empty());
}

BOOST_AUTO_TEST_CASE(a_reader_of_a_tap_that_is_slow_holds_nothing_up) {
  Loop loop(1);
  loop.b.record(0);
  LiveEngine run(loop.b.plan);
  EngineLog slow(run, loop.b.plan);
  int count = 0;
  slow.on_message = [&count] {
    if (++count % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  };
  drive(
      run, [](const EngineStatus&) { return true; }, [&] { slow.take(); });
  BOOST_TEST(!run.failure().has_value());
  // Nothing is lost: every tick that was not missed has arrived.
  BOOST_TEST(count + static_cast<int>(run.status().devices[0].missed) >= 999);
  BOOST_TEST(slow.dropped() == 0U);
}

BOOST_AUTO_TEST_CASE(a_tap_that_nobody_reads_loses_messages_and_counts_them) {
  Loop loop(0.5);
  LiveEngine run(loop.b.plan);
  Tap tap(message_type<Wrench>(), {QueuePolicy::drop_newest, 10});
  run.with_dispatcher([&](Dispatcher& dispatcher) { dispatcher.add_tap(0, 0, tap); });
  drive(run);
  BOOST_TEST(tap.dropped() > 100U);
  std::uint64_t next = 0;
  while (const MessageView view = tap.take()) BOOST_TEST(view.stamp->sequence == next++);
  BOOST_TEST(next == 10U);
}

BOOST_AUTO_TEST_CASE(a_tap_may_come_and_go_while_the_run_goes_on) {
  Loop loop(1);
  LiveEngine run(loop.b.plan);
  std::unique_ptr<Tap> tap;
  std::size_t came = 0;
  int looks = 0;
  drive(
      run, [](const EngineStatus&) { return true; },
      [&] {
        if (++looks % 4 == 0) {
          tap = std::make_unique<Tap>(message_type<Wrench>(), Queue{QueuePolicy::drop_oldest, 256});
          run.with_dispatcher([&](Dispatcher& dispatcher) { dispatcher.add_tap(0, 0, *tap); });
        } else if (looks % 4 == 3 && tap) {
          run.with_dispatcher([&](Dispatcher& dispatcher) { dispatcher.remove_tap(*tap); });
          while (tap->take()) ++came;
          tap.reset();
        }
      });
  if (tap) run.with_dispatcher([&](Dispatcher& dispatcher) { dispatcher.remove_tap(*tap); });
  BOOST_TEST(came > 100U);
  BOOST_TEST(!run.failure().has_value());
}

BOOST_AUTO_TEST_CASE(what_stops_a_run_with_a_reason_is_its_failure) {
  Loop loop(30);
  LiveEngine run(loop.b.plan);
  drive(run, [&run](const EngineStatus&) {
    run.stop("no space left");
    return true;
  });
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(*run.failure() == "no space left");
  BOOST_TEST((dynamic_cast<const Actor&>(run.nodes()[0]).seen.back().phase == Phase::stopping));
}

BOOST_AUTO_TEST_SUITE_END()
