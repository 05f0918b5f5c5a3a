// What holds when a live run ends badly: devices come to rest, and what kept them from it is told.
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <functional>
#include <memory>

#include "tests/framework/engine/live/drive.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"
#include "tests/framework/engine/sample_nodes.hpp"

BOOST_AUTO_TEST_SUITE(live_ending_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

/// A device that comes to rest after it has ticked `ticks` times while the run stops.
class Ramp final : public Node {
 public:
  struct Params {
    double rate = 1000;
    std::int32_t ticks = 0;
  };
  Ramp(const Params& params, const NodeContext&) : params_(params) {}
  static NodeInfo declare() {
    return Declare<Ramp>("sample.ramp", "Ramps.")
        .actuator()
        .output("out", &Ramp::out, "a count")
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 1000})
        .integer("ticks", &Params::ticks, {.doc = "ticks until it rests", .default_value = 50})
        .info();
  }
  void step(StepContext& context) override {
    out.send(context.now(), {});
    if (context.phase() != Phase::stopping) return;
    if (++stopping < params_.ticks) context.not_at_rest();
  }
  Output<Wrench> out;
  int stopping = 0;

 private:
  Params params_;
};

/// Does what it is told at its first step.
class Does final : public Node {
 public:
  struct Params {};
  static inline std::function<void()> deed;
  Does(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Does>("sample.does", "Does.")
        .input("in", &Does::in, {.doc = "what makes it step", .trigger = Trigger::yes})
        .output("out", &Does::out, "nothing")
        .info();
  }
  void step(StepContext&) override { deed(); }
  Input<Wrench> in;
  Output<Wrench> out;
};

struct Fixture {
  NodeInfo ramp = Ramp::declare();
  NodeInfo counter = Counter::declare();
  NodeInfo does = Does::declare();
};

/// A disk that hangs for two seconds: it takes the steps that a run tells, and sleeps at the twentieth.
class Hangs {
 public:
  explicit Hangs(LiveEngine& run) {
    run.with_dispatcher([this](Dispatcher& dispatcher) { dispatcher.add_step_tap(tap_); });
  }
  void take() {
    while (tap_.take()) {
      if (++count_ == 20) std::this_thread::sleep_for(std::chrono::seconds(2));
    }
  }

 private:
  Tap tap_{message_type<StepEvent>(), {QueuePolicy::drop_newest, 60000}};
  int count_ = 0;
};

const Ramp& ramp_of(LiveEngine& run, std::size_t node) {
  return dynamic_cast<const Ramp&>(run.nodes()[node]);
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_device_gets_all_the_time_that_its_ramp_to_zero_takes, Fixture) {
  for (const Lane lane : {Lane::realtime, Lane::pool}) {
    PlanBuilder b(0.1);
    b.node("device", ramp, {1000.0, std::int64_t{3000}}, {lane, "", SchedulingPolicy::other, {}, {}});
    LiveEngine run(b.plan);
    drive(run);
    BOOST_TEST(!run.failure().has_value());
    BOOST_TEST(ramp_of(run, 0).stopping >= 3000);
  }
}

BOOST_FIXTURE_TEST_CASE(a_device_that_does_not_come_to_rest_is_told_of, Fixture) {
  Does::deed = [] { std::this_thread::sleep_for(std::chrono::milliseconds(2700)); };
  PlanBuilder b(0.2);
  b.plan.graph.live.stall_timeout = Duration{60'000'000'000};
  const Scheduling shared{Lane::thread, "shared", {}, {}, {}};
  const auto device = b.node("device", ramp, {1000.0, std::int64_t{50}}, shared);
  const auto culprit = b.node("culprit", does, {}, shared);
  b.edge(device, culprit, 0, {}, true);
  LiveEngine run(b.plan);
  drive(run);
  BOOST_TEST(!run.is_abandoned());
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(run.failure()->find("device node device has not stopped") != std::string::npos);
}

BOOST_FIXTURE_TEST_CASE(a_node_that_throws_does_not_keep_a_device_on_its_thread_from_ramping_down, Fixture) {
  Does::deed = [] { throw std::runtime_error("it broke"); };
  PlanBuilder b(30);
  const Scheduling shared{Lane::thread, "shared", {}, {}, {}};
  const auto device = b.node("device", ramp, {1000.0, std::int64_t{50}}, shared);
  const auto culprit = b.node("culprit", does, {}, shared);
  b.edge(device, culprit, 0, {}, true);
  LiveEngine run(b.plan);
  drive(run);
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(run.failure()->find("it broke") != std::string::npos);
  BOOST_TEST(ramp_of(run, device).stopping >= 50);
}

BOOST_FIXTURE_TEST_CASE(what_is_thrown_and_is_no_exception_ends_the_run_too, Fixture) {
  Does::deed = [] { throw 42; };
  PlanBuilder b(30);
  const auto source = b.node("source", counter, {100.0});
  const auto culprit = b.node("culprit", does, {});
  b.edge(source, culprit, 0, {}, true);
  b.plan.graph.live.stall_timeout = Duration{5'000'000'000};
  LiveEngine run(b.plan);
  drive(run);
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(run.failure()->find("node culprit failed at") != std::string::npos);
}

BOOST_FIXTURE_TEST_CASE(a_step_that_is_still_on_its_way_at_the_end_is_told_of, Fixture) {
  static std::atomic<bool> released{false}, left{false};
  Does::deed = [] {
    while (!released) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    left = true;
  };
  // Its thread still uses them.
  static PlanBuilder b(0.3);
  static LiveEngine* run = nullptr;
  static NodeInfo info = Does::declare();
  static NodeInfo count = Counter::declare();
  const auto source = b.node("source", count, {100.0});
  const auto culprit = b.node("culprit", info, {});
  b.edge(source, culprit, 0, {}, true);
  b.plan.graph.live.on_stall = OnStall::recover;
  run = new LiveEngine(b.plan);
  drive(*run);
  BOOST_TEST(run->is_abandoned());
  BOOST_REQUIRE(run->failure().has_value());
  BOOST_TEST_CONTEXT(*run->failure())
  BOOST_TEST(run->failure()->find("does not come back from its step") != std::string::npos);
  released = true;
  for (int i = 0; i < 10'000 && !left; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  BOOST_TEST(left);
}

BOOST_FIXTURE_TEST_CASE(a_light_node_in_the_realtime_lane_that_throws_is_named, Fixture) {
  struct Bad final : Node {
    struct Params {
      double rate = 100;
    };
    Bad(const Params&, const NodeContext&) {}
    static NodeInfo declare() {
      return Declare<Bad>("sample.bad", "Throws.")
          .rate("rate", &Params::rate, {.doc = "rate", .default_value = 100})
          .info();
    }
    void step(StepContext&) override { throw std::runtime_error("it broke"); }
  };
  const NodeInfo bad = Bad::declare();
  PlanBuilder b(30);
  b.node("filter", bad, {100.0}, {Lane::realtime, "", SchedulingPolicy::other, {}, {}});
  LiveEngine run(b.plan);
  drive(run);
  BOOST_REQUIRE(run.failure().has_value());
  BOOST_TEST(run.failure()->find("node filter failed at") != std::string::npos);
}

BOOST_FIXTURE_TEST_CASE(a_node_of_the_realtime_lane_that_sends_nothing_has_stepped_all_the_same, Fixture) {
  struct Silent final : Node {
    struct Params {
      double rate = 100;
    };
    Silent(const Params&, const NodeContext&) {}
    static NodeInfo declare() {
      return Declare<Silent>("sample.silent", "Sends nothing.")
          .output("out", &Silent::out, "nothing")
          .rate("rate", &Params::rate, {.doc = "rate", .default_value = 100})
          .info();
    }
    void step(StepContext&) override {}
    Output<Wrench> out;
  };
  const NodeInfo silent = Silent::declare();
  const NodeInfo actor = Actor::declare();
  for (const Lane lane : {Lane::realtime, Lane::pool}) {
    PlanBuilder b(0.5);
    const auto source = b.node("source", silent, {100.0}, {lane, "", SchedulingPolicy::other, {}, {}});
    const auto device = b.node("device", actor, {1000.0}, {Lane::realtime, "", SchedulingPolicy::other, {}, {}});
    b.edge(source, device, 0, {}, false);
    LiveEngine run(b.plan);
    Phase last = Phase::starting;
    drive(run, [&last](const EngineStatus& s) {
      last = s.phase;
      return true;
    });
    BOOST_TEST((last == Phase::running));
  }
}

BOOST_FIXTURE_TEST_CASE(a_disk_that_hangs_does_not_keep_a_failure_from_the_devices, Fixture) {
  struct Late final : Node {
    struct Params {};
    Late(const Params&, const NodeContext&) {}
    static NodeInfo declare() {
      return Declare<Late>("sample.late", "Throws at the 500th message.")
          .input("in", &Late::in, {.doc = "what makes it step", .trigger = Trigger::yes})
          .info();
    }
    void step(StepContext&) override {
      if (in.latest()->stamp.sequence > 500) throw std::runtime_error("it broke");
    }
    Input<Wrench> in;
  };
  const NodeInfo late = Late::declare();
  PlanBuilder b(30);
  const auto device =
      b.node("device", ramp, {1000.0, std::int64_t{50}}, {Lane::realtime, "", SchedulingPolicy::other, {}, {}});
  const auto culprit = b.node("culprit", late, {});
  b.edge(device, culprit, 0, {}, true);
  b.record(device);
  LiveEngine run(b.plan);
  Hangs disk(run);
  drive(
      run, [](const EngineStatus&) { return true; }, [&disk] { disk.take(); });
  BOOST_REQUIRE(run.failure().has_value());
  // It broke half a second after the start, and the disk came back a second and a half later.
  BOOST_TEST(run.status().now.seconds() < 1.5);
  BOOST_TEST(ramp_of(run, device).stopping > 500);
}

BOOST_FIXTURE_TEST_CASE(a_disk_that_hangs_does_not_keep_the_run_from_being_stopped, Fixture) {
  PlanBuilder b(30);
  const auto device =
      b.node("device", ramp, {1000.0, std::int64_t{50}}, {Lane::realtime, "", SchedulingPolicy::other, {}, {}});
  b.record(device);
  LiveEngine run(b.plan);
  const auto begin = std::chrono::steady_clock::now();
  run.stop_when([begin] { return std::chrono::steady_clock::now() - begin > std::chrono::milliseconds(500); });
  Hangs disk(run);
  drive(
      run, [](const EngineStatus&) { return true; }, [&disk] { disk.take(); });
  BOOST_TEST(!run.failure().has_value());
  BOOST_TEST(run.status().now.seconds() < 1.5);
  BOOST_TEST(ramp_of(run, device).stopping > 500);
}

BOOST_AUTO_TEST_SUITE_END()
