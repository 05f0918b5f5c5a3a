// One interface for both clocks: stepped, paced and live, with taps that come and go.
#include "framework/session/session.hpp"

#include <array>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/value_error.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/node/plugin.hpp"
#include "tests/framework/engine/sample_nodes.hpp"
#include "tests/support/needs_live.hpp"

BOOST_AUTO_TEST_SUITE(session_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

constexpr std::int64_t ms = 1'000'000;

CostModel five_milliseconds() {
  CostModel cost;
  cost.kind = CostModel::Kind::constant;
  cost.base = Duration{5 * ms};
  return cost;
}

/// What a run is to be asked for.
enum class By { whole, steps, pace, live };

/// The counts that the keeper of a sample plan got.
std::vector<double> run(By by, double duration_s, double& wall_s) {
  SamplePlan sample(five_milliseconds(), duration_s, {QueuePolicy::drop_oldest, 64});
  sample.plan.graph.clock = by == By::live ? Clock::real : Clock::virtual_;
  const auto begin = std::chrono::steady_clock::now();
  Session session(sample.plan, {.engine = {.pace = by == By::pace ? 1.0 : 0.0}});
  BOOST_TEST(!session.is_running());
  session.start();
  while (session.is_running()) session.advance(by == By::whole ? Duration::from_seconds(duration_s) : Duration{7 * ms});
  session.finish();
  BOOST_TEST(!session.failure().has_value());
  wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::vector<double> values;
  for (const Keep::Entry& entry : dynamic_cast<const Keep&>(session.nodes()[2]).kept) values.push_back(entry.value);
  return values;
}

double x_of(const void* value) {
  Wrench w;
  std::memcpy(&w, value, sizeof w);
  return w.force.x;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_same_graph_runs_stepped_paced_and_live, *boost::unit_test::precondition(test::NeedsLive{})) {
  double at_once = 0, stepped = 0, paced = 0, live = 0;
  const std::vector<double> whole = run(By::whole, 1.0, at_once);
  BOOST_TEST(whole.size() == 199U);
  BOOST_TEST(run(By::steps, 1.0, stepped) == whole, boost::test_tools::per_element());
  BOOST_TEST(run(By::pace, 1.0, paced) == whole, boost::test_tools::per_element());
  BOOST_TEST(paced >= 1.0);
  // A live run counts in the same order, at its own speed.
  const std::vector<double> real = run(By::live, 1.0, live);
  BOOST_TEST(live >= 1.0);
  BOOST_TEST(real.size() > 100U);
  for (std::size_t i = 1; i < real.size(); ++i) BOOST_TEST(real[i] > real[i - 1]);
}

BOOST_AUTO_TEST_CASE(a_tap_comes_and_goes_while_a_session_runs, *boost::unit_test::precondition(test::NeedsLive{})) {
  for (const Clock clock : {Clock::virtual_, Clock::real}) {
    SamplePlan sample({}, 1.0);
    sample.plan.graph.clock = clock;
    Session session(sample.plan);
    session.start();
    session.advance(Duration{200 * ms});
    std::vector<double> counts;
    {
      const auto tap = session.tap("counter.out");
      session.advance(Duration{200 * ms});
      while (const MessageView message = tap->take()) counts.push_back(x_of(message.value));
      BOOST_TEST(tap->dropped() == 0U);
    }
    session.advance(Duration{200 * ms});
    session.stop();
    session.finish();
    BOOST_TEST(counts.size() > 100U);
    BOOST_TEST(counts.front() > 100);
    for (std::size_t i = 1; i < counts.size(); ++i) BOOST_TEST(counts[i] == counts[i - 1] + 1);
    BOOST_TEST(session.node_statistics(0).steps < 900U);
  }
}

BOOST_AUTO_TEST_CASE(under_the_virtual_clock_no_message_is_lost_on_its_way_to_who_takes_it) {
  const SamplePlan sample({}, 5.0);
  Session session(sample.plan);
  std::vector<double> counts;
  std::size_t steps = 0;
  session.on_message(
      "counter.out", [&counts](const Stamp&, const void* value) { counts.push_back(x_of(value)); }, 64);
  session.on_step([&steps](const Stamp&, const void*) { ++steps; }, 64);
  session.start();
  session.advance(Duration::from_seconds(5));
  session.finish();
  BOOST_REQUIRE(counts.size() == 5000U);
  for (std::size_t i = 0; i < counts.size(); ++i) BOOST_REQUIRE(counts[i] == static_cast<double>(i));
  BOOST_TEST(steps == 15000U);
  BOOST_TEST(session.dropped() == 0U);
}

BOOST_AUTO_TEST_CASE(what_a_taker_throws_ends_the_run, *boost::unit_test::precondition(test::NeedsLive{})) {
  for (const Clock clock : {Clock::virtual_, Clock::real}) {
    SamplePlan sample({}, 30.0);
    sample.plan.graph.clock = clock;
    Session session(sample.plan);
    int count = 0;
    session.on_message("counter.out", [&count](const Stamp&, const void*) {
      if (++count == 100) throw RunError("no space left");
    });
    session.start();
    if (clock == Clock::virtual_) {
      BOOST_CHECK_THROW(session.advance(Duration::from_seconds(30)), RunError);
    } else {
      while (session.is_running()) session.advance(Duration{50 * ms});
      session.finish();
      BOOST_REQUIRE(session.failure().has_value());
      BOOST_TEST(*session.failure() == "no space left");
    }
    BOOST_TEST(count == 100);
  }
}

namespace {

/// Sends its parameter at a rate.
class Tuned final : public Node {
 public:
  struct Params {
    double k = 0;
    double fixed = 0;
    double rate = 1000;
  };
  Tuned(const Params& params, const NodeContext&) : params_(params) {
    if (params.k > params.fixed) throw ValueError("k", "k is above fixed");
  }
  static NodeInfo declare() {
    return Declare<Tuned>("sample.tuned", "Sends its parameter.")
        .output("out", &Tuned::out, "k")
        .real("k", &Params::k, {.doc = "what it sends", .unit = "N/m", .default_value = 500, .min = 0, .max = 2000})
        .real("fixed", &Params::fixed, {.doc = "the most that k may be", .unit = "N/m", .default_value = 1500})
        .tunable({"k"})
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 1000})
        .info();
  }
  [[nodiscard]] std::string refuses(const Params& params) const { return params.k == 666 ? "666 is no stiffness" : ""; }
  void tune(const Params& params) { params_ = params; }
  void step(StepContext& context) override { out.send(context.now(), {{params_.k, 0, 0}, {}}); }
  Output<Wrench> out;

 private:
  Params params_;
};

struct TunedPlan {
  NodeInfo tuned = Tuned::declare();
  NodeInfo keep = Keep::declare();
  Plan plan;

  explicit TunedPlan(Clock clock) {
    plan.graph.duration = Duration::from_seconds(10);
    plan.graph.clock = clock;
    plan.nodes = {{"spring", &tuned, {500.0, 1500.0, 1000.0}, {}, {}, {}}, {"keep", &keep, {}, {}, {}, {}}};
    PlannedEdge edge;
    edge.spec = {"spring", "out", "keep", "in", {QueuePolicy::drop_oldest, 64}, true, {}, {}};
    edge.to = 1;
    edge.triggers = true;
    plan.edges = {edge};
  }
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_parameter_is_set_between_two_steps, *boost::unit_test::precondition(test::NeedsLive{})) {
  for (const Clock clock : {Clock::virtual_, Clock::real}) {
    TunedPlan tuned(clock);
    Session session(tuned.plan);
    std::vector<std::pair<Time, std::string>> told;
    session.on_set([&told](const Stamp& stamp, const void* value) {
      SetEvent event;
      std::memcpy(static_cast<void*>(&event), value, sizeof event);
      told.emplace_back(stamp.valid, std::string(event.text.begin(), event.text.begin() + event.length));
    });
    session.start();
    session.advance(Duration{100 * ms});
    session.set("spring.k", "1.2 N/mm");
    session.advance(Duration{100 * ms});
    session.set("spring.k", "300");
    session.advance(Duration{100 * ms});
    session.stop();
    session.finish();
    BOOST_REQUIRE(told.size() == 2U);
    BOOST_TEST(told[0].second == "k=1.2 N/mm");
    BOOST_TEST(told[1].second == "k=300");
    std::size_t seen = 0;
    for (const Keep::Entry& entry : dynamic_cast<const Keep&>(session.nodes()[1]).kept) {
      // From the step on that begins at or after the time that was told.
      const double expected = entry.stamp.valid < told[0].first ? 500 : entry.stamp.valid < told[1].first ? 1200 : 300;
      BOOST_TEST(entry.value == expected);
      ++seen;
    }
    BOOST_TEST(seen > 200U);
    if (clock == Clock::virtual_) BOOST_TEST((told[0].first == Time{100 * ms} && told[1].first == Time{200 * ms}));
  }
}

BOOST_AUTO_TEST_CASE(what_cannot_be_set_is_refused_with_the_reason_and_changes_nothing) {
  TunedPlan tuned(Clock::virtual_);
  Session session(tuned.plan);
  session.start();
  const auto refusal = [&session](const char* parameter, const char* value) {
    try {
      session.set(parameter, value);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  const auto says = [&](const char* parameter, const char* value, const char* part) {
    const std::string text = refusal(parameter, value);
    BOOST_TEST(text.find(part) != std::string::npos, parameter << "=" << value << ": " << text);
  };
  says("spring.k", "-1", "spring.k");
  says("spring.k", "3 N", "N/m");
  says("spring.k", "stiff", "spring.k");
  says("spring.k", "", "spring.k");
  says("spring.k", "[1, 2]", "spring.k");
  says("spring.k", "1: {", "set spring.k");
  says("spring.k", "1800", "k is above fixed");
  says("spring.k", "666", "666 is no stiffness");
  says("spring.k", std::string(1000, '1').c_str(), "spring.k");
  says("spring.fixed", "1", "cannot be set during the run");
  says("spring.q", "1", "did you mean \"spring.k\"");
  says("keep.k", "1", "no parameter keep.k");
  session.advance(Duration{10 * ms});
  for (const Keep::Entry& entry : dynamic_cast<const Keep&>(session.nodes()[1]).kept) BOOST_TEST(entry.value == 500);
}

BOOST_AUTO_TEST_CASE(an_output_that_is_not_there_is_told_with_the_nearest_and_the_reason) {
  SamplePlan sample({}, 1.0);
  sample.plan.left_out.push_back({"node refit", "the coefficients are fixed", LeftOut::Kind::node, "refit"});
  Session session(sample.plan);
  const auto refusal = [&session](const char* name) {
    try {
      static_cast<void>(session.tap(name));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  BOOST_TEST(refusal("counter.ouzt").find("did you mean \"counter.out\"") != std::string::npos,
             refusal("counter.ouzt"));
  BOOST_TEST(refusal("refit.coefficients").find("its node was left out, because the coefficients are fixed") !=
             std::string::npos);
  BOOST_TEST(refusal("counter").find("no output counter") != std::string::npos);
}

namespace {

/// A thread that does one thing after another, and lives until the end of the test.
class Worker {
 public:
  Worker() : thread_([this] { run(); }) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    does([this] { over_ = true; });
    thread_.join();
  }
  /// Returns once the thread has done it.
  void does(const std::function<void()>& job) {
    std::packaged_task<void()> task(job);
    std::future<void> done = task.get_future();
    {
      const std::scoped_lock lock(mutex_);
      task_ = std::move(task);
    }
    changed_.notify_one();
    done.get();
  }

 private:
  void run() {
    while (!over_) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return task_.has_value(); });
      std::packaged_task<void()> task = *std::exchange(task_, std::nullopt);
      lock.unlock();
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<std::packaged_task<void()>> task_;
  bool over_ = false;  // the thread's own
  std::thread thread_;
};

}  // namespace

// Each of the six calls on either of two threads, and once each on a thread of its own.
BOOST_AUTO_TEST_CASE(each_call_of_a_live_session_may_come_from_another_thread,
                     *boost::unit_test::precondition(test::NeedsLive{})) {
  constexpr std::size_t calls = 6;
  std::array<Worker, calls> workers;
  for (unsigned way = 0; way <= 1U << calls; ++way) {
    BOOST_TEST_CONTEXT("way " << way) {
      std::size_t call = 0;
      const auto next = [&](const std::function<void()>& job) {
        const bool own = way == 1U << calls;
        workers[own ? call : way >> call & 1U].does(job);
        ++call;
      };
      SamplePlan sample({}, 1000.0);
      sample.plan.graph.clock = Clock::real;
      std::unique_ptr<Session> session;
      next([&] { session = std::make_unique<Session>(sample.plan); });
      next([&] { session->start(); });
      next([&] { session->advance(Duration{30 * ms}); });
      next([&] { session->stop(); });
      next([&] { session->finish(); });
      BOOST_TEST(!session->failure().has_value());
      BOOST_TEST(session->node_statistics(0).steps > 0U);
      next([&] { session.reset(); });
      BOOST_TEST(call == calls);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_live_session_may_be_stopped_beside_another_call,
                     *boost::unit_test::precondition(test::NeedsLive{})) {
  Worker starts, stops;
  SamplePlan sample({}, 1000.0);
  sample.plan.graph.clock = Clock::real;
  std::unique_ptr<Session> session;
  starts.does([&] {
    session = std::make_unique<Session>(sample.plan);
    session->start();
  });
  stops.does([&] {
    std::jthread beside([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      session->stop();
    });
    while (session->is_running()) session->advance(Duration{ms});
    session->finish();
  });
  BOOST_TEST(!session->failure().has_value());
  BOOST_TEST(session->status().now.seconds() < 500.0);
}

BOOST_AUTO_TEST_SUITE_END()
