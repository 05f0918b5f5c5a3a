// A device whose maker's library calls back at its own pace: the loop follows, grippers and status pass, silence is
// found.
#include <algorithm>
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "devices/hardware/declare_hardware.hpp"
#include "framework/core/segment.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/periodic_loop.hpp"
#include "tests/devices/hardware/scripted_link.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(callback_line_test)

using namespace tactor;
using tactor::test::eventually;

namespace {

/// What the test and the maker's library share; it outlives the line.
struct Maker {
  std::atomic<bool> calls{true};  ///< false: the library hangs
  std::atomic<double> temperature{31};
  std::atomic<int> openings{0}, closings{0};
  std::atomic<std::int64_t> sampled_ns{0};  ///< when the newest sample was taken, by the library
  std::atomic<bool> is_open{false};
  std::atomic<int> calls_while_closed{0};

  std::mutex mutex;
  std::vector<AxisValues> efforts;  ///< that it was given
  [[nodiscard]] AxisValues newest() {
    const std::scoped_lock lock(mutex);
    return efforts.empty() ? AxisValues{} : efforts.back();
  }
};

/// A pose with six axes, of which the last has no motor, and a gripper. Its thread calls back 1,000 times a second by a
/// clock that is .3 % slower than ours.
class MakersLink final : public Link {
 public:
  explicit MakersLink(Maker& maker) : maker_(maker) {}
  ~MakersLink() override { close(); }
  [[nodiscard]] std::string name() const override { return "makers device"; }
  [[nodiscard]] LinkPace pace() const override { return LinkPace::callback; }
  [[nodiscard]] LinkLimits limits() const override {
    LinkLimits limits;
    limits.q_min = {-0.1, -0.1, -0.1};
    limits.q_max = {0.1, 0.1, 0.1};
    return limits;
  }
  bool open(LinkFailure&) override {
    ++maker_.openings;
    maker_.is_open = true;
    return true;
  }
  void start(LinkTurn& turn) override {
    stop_ = false;
    thread_ = std::thread([this, &turn] { run(turn); });
  }
  void close() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (maker_.is_open.exchange(false)) ++maker_.closings;
  }

 private:
  void run(LinkTurn& turn) {
    apply_thread_settings({SchedulingPolicy::fifo, 85, std::nullopt}, "maker");
    Instant next = MonotonicClock::now();
    for (int n = 0; !stop_; ++n) {
      next = next + Duration{1'003'000};
      MonotonicClock::sleep_until(next);
      if (!maker_.calls) continue;
      if (!maker_.is_open) ++maker_.calls_while_closed;
      LinkSample sample;
      const double trembles = 1e-6 * (n % 2);
      sample.q = {trembles, 0.01 * std::sin(0.01 * n), 0.02 + trembles, 0, 0, 0, 0.03};
      sample.R_BD = from_rotation_vector(0.004 * n * Vec3{0.6, 0.64, 0.48});
      sample.buttons = 1;
      sample.status[0] = maker_.temperature;
      maker_.sampled_ns = MonotonicClock::now().ns;
      const LinkCommand command = turn.turn(sample);
      const std::scoped_lock lock(maker_.mutex);
      maker_.efforts.push_back(command.effort);
    }
  }

  Maker& maker_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

Maker* maker = nullptr;

const StatusInfo status_list[] = {{"temperature", "K", "the motor's temperature"}};

class MakersDevice final : public HardwareDevice {
 public:
  struct Params : HardwareParams {};
  MakersDevice(const Params& params, const NodeContext& context) : HardwareDevice(params, context, parts()) {}
  static NodeInfo declare() {
    Declare<MakersDevice> declaration("test.makers_device", "A maker's library that calls back.");
    HardwareParams defaults;
    defaults.link_timeout = Duration{200'000'000};
    defaults.recovery_time = Duration{50'000'000};
    declare_hardware(declaration, defaults);
    declare_gripper(declaration);
    declare_status(declaration, status_list);
    return declaration.info();
  }

 private:
  static HardwareParts parts() {
    HardwareParts parts;
    parts.link = std::make_unique<MakersLink>(*maker);
    parts.limits.axes = 7;
    parts.limits.pose = true;
    parts.limits.role[5] = AxisRole::sensed;
    parts.limits.role[6] = AxisRole::gripper;
    parts.limits.effort_max = {8, 8, 8, 0.2, 0.2, 0, 5};
    parts.limits.speed_max = {2, 2, 2, 30, 30, 30, 2};
    parts.limits.jump_tolerance = {1e-3, 1e-3, 1e-3, 0.05, 0.05, 0.05, 1e-3};
    parts.buttons = 1;
    parts.status = 1;
    return parts;
  }
};

/// The device in a loop of its own, as in the real-time lane.
class Bench {
 public:
  Bench() {
    maker = &library;
    const NodeInfo info = MakersDevice::declare();
    NodeContext context;
    context.name = "device";
    context.scene = &scene_;
    context.duration = Duration{10'000'000'000};
    node_ = info.create(test::param_values(info, {}), context);
    device().segment.configure({QueuePolicy::latest, 1});
    device().gripper_force.configure({QueuePolicy::latest, 1});
    for (OutputBase* output : std::initializer_list<OutputBase*>{&device().gripper, &device().status, &device().state,
                                                                 &device().commanded, &device().safety}) {
      output->set_wanted(true);
    }
    StepContext start(Time{}, Phase::starting);
    device().start(start);
  }
  ~Bench() { stop(); }

  MakersDevice& device() { return dynamic_cast<MakersDevice&>(*node_); }
  void start(bool paced = true) {
    ages_ns.reserve(100'000);
    LoopSettings settings{.name = "device", .rate = 1000, .thread = {SchedulingPolicy::fifo, 80, std::nullopt}};
    if (paced) settings.pace = device().pace();
    loop_ = std::make_unique<PeriodicLoop>(settings, [this](const Tick& tick) { step(tick); });
    loop_->start(MonotonicClock::now() + Duration{5'000'000});
  }
  void stop() {
    if (loop_) BOOST_TEST(loop_->stop(Duration{10'000'000'000}));
  }
  [[nodiscard]] std::int64_t ticks() const { return loop_->metrics().ended.value(); }
  [[nodiscard]] const LoopStatistics& metrics() const { return loop_->metrics(); }
  double metric(const std::string& name) {
    Report report;
    report.ask(device(), "device", MakersDevice::declare().metrics);
    return test::metrics_of(report).at(name);
  }

  Maker library;
  std::vector<std::int64_t> ages_ns;  ///< of each sample at the tick that takes it, by the library's own stamps
  std::atomic<bool> engaged{false};
  std::atomic<double> opening{0}, told_temperature{0};
  std::atomic<int> told{0};
  std::atomic<double> grip{0};

 private:
  void step(const Tick& tick) {
    // A tick without a new sample is one of a library that was late itself.
    const std::int64_t sampled = library.sampled_ns;
    const bool is_new = std::exchange(newest_ns_, sampled) != sampled;
    if (is_new && ages_ns.size() < ages_ns.capacity()) ages_ns.push_back(MonotonicClock::now().ns - sampled);
    const Stamp stamp{tick.deadline, tick.deadline, ++sequence_};
    const ForceSegment segment = constant_segment(tick.deadline, {{0.5, 1, 2}, {0.05, 0.02, 0.05}});
    device().segment.push(stamp, &segment);
    const GripperForce force{grip};
    device().gripper_force.push(stamp, &force);
    device().gripper_force.queue().admit();
    StepContext context(tick.deadline, Phase::running);
    device().step(context);
    if (device().gripper.pending() > 0) {
      opening = static_cast<const GripperState*>(device().gripper.pending_value(0))->opening;
    }
    if (device().status.pending() > 0) {
      told_temperature = static_cast<const HardwareStatus*>(device().status.pending_value(0))->value[0];
      ++told;
    }
    engaged = static_cast<const SafetyState*>(device().safety.pending_value(0))->engagement == Engagement::engaged;
    for (OutputBase* output :
         std::initializer_list<OutputBase*>{&device().state, &device().interpolated, &device().commanded,
                                            &device().safety, &device().gripper, &device().status}) {
      output->clear_pending();
    }
  }

  Scene scene_;
  std::unique_ptr<Node> node_;
  std::unique_ptr<PeriodicLoop> loop_;
  std::uint64_t sequence_ = 0;
  std::int64_t newest_ns_ = 0;
};

double share_in_ms(std::vector<std::int64_t> ages_ns, double share) {
  ages_ns.erase(ages_ns.begin(), ages_ns.begin() + 200);  // of the start
  const auto at = ages_ns.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(ages_ns.size() - 1));
  std::nth_element(ages_ns.begin(), at, ages_ns.end());
  return 1e-6 * static_cast<double>(*at);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_loop_takes_each_sample_soon_after_the_library_has_called_back) {
  const MemoryLock locked;
  constexpr int tries = 10;
  double p99 = 0;
  for (int i = 0; i < tries; ++i) {
    Bench bench;
    bench.start();
    BOOST_TEST_REQUIRE(eventually([&] { return bench.ticks() > 3000; }));
    bench.stop();
    p99 = share_in_ms(bench.ages_ns, 0.99);
    BOOST_TEST_MESSAGE("sample age p50 " << share_in_ms(bench.ages_ns, 0.5) << " ms, p99 " << p99 << " ms");
    BOOST_TEST(bench.metric("device.jumps") == 0);
    if (p99 <= 0.6) break;
  }
  BOOST_TEST(p99 <= 0.6);
}

BOOST_AUTO_TEST_CASE(forces_gripper_and_status_pass_and_an_axis_without_a_motor_gets_exactly_zero) {
  Bench bench;
  bench.start();
  bench.grip = 2;
  BOOST_TEST(eventually([&] { return bench.engaged && std::abs(bench.library.newest()[6] - 2) < 1e-12; }));
  BOOST_TEST(eventually([&] { return std::abs(bench.library.newest()[2] - 2) < 1e-9; }));
  const AxisValues given = bench.library.newest();
  BOOST_TEST(std::abs(given[0] - 0.5) < 1e-9);
  BOOST_TEST(std::abs(given[3] - 0.05) < 1e-9);
  bench.grip = -20;
  BOOST_TEST(eventually([&] { return bench.library.newest()[6] == -5; }));  // no more than its motor can
  BOOST_TEST(bench.opening == 0.03);
  BOOST_TEST(eventually([&] { return bench.told == 1; }));
  bench.library.temperature = 48;
  BOOST_TEST(eventually([&] { return bench.told_temperature == 48.0; }));
  bench.library.temperature = 33;
  BOOST_TEST(eventually([&] { return bench.told_temperature == 33.0; }));
  bench.stop();
  BOOST_TEST(bench.told == 3);
  BOOST_TEST(bench.metric("device.status.temperature") == 33);
  BOOST_TEST(bench.metric("device.status.temperature.most") == 48);
  BOOST_TEST(bench.metric("device.jumps") == 0);
  const double late = bench.metric("device.link.expired");
  const std::scoped_lock lock(bench.library.mutex);
  double grip = 0;
  for (const AxisValues& effort : bench.library.efforts) {
    BOOST_TEST_REQUIRE(effort[5] == 0.0);
    // The gripper's motor comes in over engage_time, 0.1 s for its 5 N, or a few ticks late.
    // A command that has expired on a busy machine goes to zero at once, and comes back by the slew limit.
    BOOST_TEST_REQUIRE((std::abs(effort[6] - grip) < 0.05 * 20 || effort[6] == 0.0 || late > 0));
    grip = effort[6];
  }
}

BOOST_AUTO_TEST_CASE(a_library_that_hangs_is_closed_and_opened_anew_and_the_force_comes_back_by_its_ramp) {
  Bench bench;
  bench.start();
  BOOST_TEST(eventually([&] { return bench.engaged && bench.library.newest()[2] > 1.9; }));
  bench.library.calls = false;
  BOOST_TEST(eventually([&] { return bench.library.closings >= 1 && !bench.engaged; }));
  BOOST_TEST(bench.ticks() > 0);
  {
    const std::scoped_lock lock(bench.library.mutex);
    bench.library.efforts.clear();
  }
  bench.library.calls = true;
  BOOST_TEST(eventually([&] { return bench.engaged && bench.library.newest()[2] > 1.9; }));
  bench.stop();
  BOOST_TEST(bench.library.openings >= 2);
  BOOST_TEST(bench.library.calls_while_closed == 0);
  BOOST_TEST(bench.metric("device.link.errors.timeout") >= 1);
  const std::scoped_lock lock(bench.library.mutex);
  BOOST_TEST(bench.library.efforts.front()[2] == 0.0);
  int between = 0;
  for (const AxisValues& effort : bench.library.efforts) between += effort[2] > 0.1 && effort[2] < 1.9 ? 1 : 0;
  BOOST_TEST(between > 0);
}

BOOST_AUTO_TEST_SUITE_END()
