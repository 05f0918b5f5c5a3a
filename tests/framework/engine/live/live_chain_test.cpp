// Nodes of the real-time lane that share a loop in a live run: failures, stalls, and the run made again.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cstring>
#include <utility>
#include <vector>

#include "framework/engine/replay_engine.hpp"
#include "tests/framework/engine/live/drive.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"

BOOST_AUTO_TEST_SUITE(live_chain_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

/// A stage and a device in one loop, and a worker in the pool that the stage feeds and hears.
struct Loop {
  NodeInfo actor = Actor::declare();
  NodeInfo filters = Filter::declare();
  NodeInfo workers = Worker::declare();
  PlanBuilder b;
  std::size_t stage, device, worker;

  explicit Loop(double duration_s, std::vector<ParamValue> of_stage = filter(1000, 0.5))
      : b(duration_s),
        stage(b.node("stage", filters, std::move(of_stage), in_loop)),
        device(b.node("device", actor, {1000.0}, in_loop)),
        worker(b.node("worker", workers, {0.002})) {
    b.edge(device, stage, 0, {}, false);
    b.edge(stage, device, 0, {}, false);
    b.edge(stage, worker, 0, {QueuePolicy::drop_oldest, 8}, true);
    b.edge(worker, stage, 1, {}, false);
  }
};

const Actor& actor_of(Engine& run, const Loop& loop) {
  return dynamic_cast<const Actor&>(run.nodes()[loop.device]);
}
const Filter& stage_of(Engine& run, const Loop& loop) {
  return dynamic_cast<const Filter&>(run.nodes()[loop.stage]);
}

/// What a live run tells of itself, as a recording keeps it.
struct Told {
  Told(Engine& engine, const Plan& plan) : log(engine, plan) {
    engine.with_dispatcher([this](Dispatcher& dispatcher) {
      dispatcher.add_tick_tap(ticks);
      dispatcher.add_stop_tap(stops);
    });
  }
  RunLog run_log(const Plan& plan) {
    log.take();
    BOOST_TEST(log.dropped() + ticks.dropped() == 0U);
    RunLog told;
    const auto reach = [&told](Time t) { told.end = std::max(told.end, t); };
    for (const auto& [begun, node, cost] : log.steps) {
      if (plan.nodes[node].scheduling.lane == Lane::realtime) continue;
      told.steps.push_back({node, Time{begun}, Time{begun + cost}});
      reach(Time{begun + cost});
    }
    ticks.take_all([&](const Stamp& stamp, const void* value) {
      TickEvent event;
      std::memcpy(static_cast<void*>(&event), value, sizeof event);
      told.ticks.push_back({event, stamp.valid, stamp.produced});
      reach(stamp.produced);
    });
    stops.take_all([&](const Stamp& stamp, const void* /*value*/) {
      told.stop = stamp.produced;
      reach(stamp.produced);
    });
    return told;
  }

  EngineLog log;
  Tap ticks{message_type<TickEvent>(), {QueuePolicy::drop_newest, 20000}};
  Tap stops{message_type<StopEvent>(), {QueuePolicy::drop_newest, 4}};
};

/// Messages with their values, by stream and sequence.
std::vector<std::pair<LoggedMessage, double>> sorted(const EngineLog& log) {
  std::vector<std::pair<LoggedMessage, double>> all;
  for (std::size_t i = 0; i < log.messages.size(); ++i) all.emplace_back(log.messages[i], log.values[2 * i]);
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_live_run_with_a_chain_is_made_again_to_the_last_value) {
  Loop loop(1.0);
  for (const std::size_t n : {loop.stage, loop.device, loop.worker}) loop.b.record(n);
  LiveEngine run(loop.b.plan);
  Told told(run, loop.b.plan);
  drive(
      run, [](const EngineStatus&) { return true; }, [&] { told.log.take(); });
  BOOST_REQUIRE_MESSAGE(!run.failure(), run.failure().value_or(""));
  BOOST_REQUIRE(run.status().devices.size() == 2U);
  BOOST_TEST(run.status().devices[0].ticks == run.status().devices[1].ticks);
  RunLog log = told.run_log(loop.b.plan);
  BOOST_TEST(log.ticks.size() > 500U);

  ReplayEngine again(loop.b.plan, log);
  EngineLog replayed(again, loop.b.plan);
  again.run();
  replayed.take();
  BOOST_TEST((sorted(told.log) == sorted(replayed)));
  const auto& live_shown = actor_of(run, loop).seen;
  const auto& shown = actor_of(again, loop).seen;
  BOOST_REQUIRE(live_shown.size() == shown.size());
  const auto same = [](const Actor::Seen& a, const Actor::Seen& c) {
    return a.now == c.now && a.phase == c.phase && a.any == c.any && a.produced == c.produced && a.value == c.value;
  };
  BOOST_TEST(std::equal(shown.begin(), shown.end(), live_shown.begin(), same));
  const auto& seen = stage_of(again, loop).seen;
  BOOST_REQUIRE(seen.size() == stage_of(run, loop).seen.size());
  double heard = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Filter::Seen& live = stage_of(run, loop).seen[i];
    BOOST_REQUIRE((seen[i].now == live.now && seen[i].value == live.value && seen[i].other == live.other));
    BOOST_REQUIRE((seen[i].stamp.produced == live.now && live.stamp.produced == live.now));
    BOOST_REQUIRE(seen[i].stamp.sequence == live.stamp.sequence);
    heard = std::max(heard, live.other);
  }
  BOOST_TEST(heard > 0);

  // As of a build in which the stage had a loop of its own and saw the device a tick late.
  for (RunLog::Tick& tick : log.ticks) {
    if (static_cast<std::size_t>(tick.event.node) == loop.stage) --tick.event.seen[0];
  }
  ReplayEngine of_before(loop.b.plan, log);
  BOOST_CHECK_EXCEPTION(of_before.run(), InputError, [](const InputError& error) {
    const std::string text = error.what();
    return text.find("edge device.out -> stage.in") != std::string::npos &&
           text.find("stage had a loop of its own") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(a_stage_that_throws_ends_the_run_while_the_device_of_its_loop_ramps_down) {
  Loop loop(30, filter(1000, 1, 50));
  LiveEngine run(loop.b.plan);
  drive(run);
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(run.failure()->starts_with("node stage failed at "), *run.failure());
  BOOST_TEST(run.failure()->ends_with("it broke"), *run.failure());
  BOOST_TEST(!run.is_abandoned());
  BOOST_TEST(stage_of(run, loop).seen.size() == 50U);
  const auto& seen = actor_of(run, loop).seen;
  const auto stopping =
      std::count_if(seen.begin(), seen.end(), [](const Actor::Seen& one) { return one.phase == Phase::stopping; });
  BOOST_TEST(stopping >= 50);
}

BOOST_AUTO_TEST_CASE(a_stage_that_hangs_is_named_with_the_device_that_it_holds_up) {
  Loop loop(30, filter(1000, 1, 50, 0.9));
  loop.b.plan.graph.live.stall_timeout = Duration{200'000'000};
  LiveEngine run(loop.b.plan);
  drive(run);
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(run.failure()->starts_with("node stage (sample.filter) has stalled: "), *run.failure());
  BOOST_TEST(run.failure()->ends_with("; it shares its loop with device"), *run.failure());
  BOOST_TEST(!run.is_abandoned());
  // It has come back within the time that the end waits for a device.
  BOOST_TEST((actor_of(run, loop).seen.back().phase == Phase::stopping));
}

BOOST_AUTO_TEST_CASE(a_node_of_a_chain_is_set_by_itself_while_the_run_goes_on) {
  Loop loop(1.0);
  LiveEngine run(loop.b.plan);
  bool set = false, in_force = false;
  drive(run, [&](const EngineStatus&) {
    if (!set) {
      run.set(loop.stage, std::make_shared<const Filter::Params>(Filter::Params{.gain = -1}), SetEvent{});
      set = true;
    } else {
      in_force = in_force || run.is_set(loop.stage);
    }
    return true;
  });
  BOOST_TEST(!run.failure().has_value());
  BOOST_TEST(in_force);
  BOOST_TEST(run.is_set(loop.device));
}

BOOST_AUTO_TEST_SUITE_END()
