// device.mouse: the cursor leads the handle, and is the dead-man button as well.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "devices/mouse/mouse.hpp"
#include "framework/core/check.hpp"
#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(mouse_test)

using namespace tactor;

namespace {

constexpr Duration period{1'000'000};
constexpr Wrench push{{0, 0, 2}, {}};

class Bench {
 public:
  explicit Bench(const std::map<std::string, ParamValue>& given = {}) {
    const NodeInfo info = MouseDevice::declare();
    NodeContext context;
    context.name = "device";
    context.scene = &scene_;
    context.torque = true;
    context.duration = Duration{10'000'000'000};
    node_ = info.create(test::param_values(info, given), context);
    device().cursor.configure({QueuePolicy::latest, 1});
    device().segment.configure({QueuePolicy::latest, 1});
  }
  [[nodiscard]] MouseDevice& device() { return dynamic_cast<MouseDevice&>(*node_); }
  void cursor(const Vec3& p, bool held) {
    Cursor message;
    message.X_WC.p = p;
    message.held = held ? 1 : 0;
    send(message);
  }
  void send(const Cursor& message) { device().cursor.push({now_, now_, sequence_++}, &message); }
  /// A tick with a fresh segment of `push`.
  void tick() {
    const ForceSegment segment = constant_segment(now_, push);
    device().segment.push({now_, now_, sequence_++}, &segment);
    StepContext context(now_);
    device().step(context);
    if (device().state.pending() > 0) state = *static_cast<const DeviceState*>(device().state.pending_value(0));
    commanded = *static_cast<const Wrench*>(device().commanded.pending_value(0));
    safety = *static_cast<const SafetyState*>(device().safety.pending_value(0));
    device().state.clear_pending();
    device().commanded.clear_pending();
    device().interpolated.clear_pending();
    device().safety.clear_pending();
    now_ = now_ + period;
  }
  /// For `seconds`, with a cursor each 16 ms.
  void hold(double seconds, const Vec3& p, bool held) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
      if (i % 16 == 0) cursor(p, held);
      tick();
    }
  }
  void leave(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) tick();
  }

  DeviceState state;
  Wrench commanded;
  SafetyState safety;

 private:
  Scene scene_;
  std::unique_ptr<Node> node_;
  Time now_{1'000'000'000};
  std::uint64_t sequence_ = 1;
};

}  // namespace

BOOST_AUTO_TEST_CASE(before_the_first_cursor_the_handle_is_at_its_start_and_gets_no_force) {
  Bench bench({{"start", std::vector<double>{0.1, 0.2, 0.3}}, {"start_rotation", std::vector<double>{0, 0, 1}}});
  bench.leave(0.5);
  BOOST_TEST(norm(bench.state.X_WD.p - Vec3{0.1, 0.2, 0.3}) < 1e-15);
  BOOST_TEST(norm(to_rotation_vector(bench.state.X_WD.R) - Vec3{0, 0, 1}) < 1e-12);
  BOOST_TEST(norm(bench.commanded.force) == 0.0);
  BOOST_TEST((bench.safety.cause == SafetyCause::dead_man));
}

BOOST_AUTO_TEST_CASE(the_handle_follows_the_cursor_and_a_held_one_engages) {
  Bench bench;
  bench.hold(0.5, {0.02, 0, 0}, false);
  BOOST_TEST(norm(bench.state.X_WD.p - Vec3{0.02, 0, 0}) < 1e-9);
  BOOST_TEST(bench.state.buttons == 0);
  BOOST_TEST(norm(bench.commanded.force) == 0.0);
  bench.hold(0.5, {0.02, 0, 0}, true);
  BOOST_TEST(bench.state.buttons == 1);
  BOOST_TEST((bench.safety.engagement == Engagement::engaged));
  BOOST_TEST(norm(bench.commanded.force - push.force) < 1e-12);
  bench.hold(0.2, {0.02, 0, 0}, false);
  BOOST_TEST(norm(bench.commanded.force) == 0.0);
}

BOOST_AUTO_TEST_CASE(a_cursor_that_stops_coming_releases_within_its_timeout_and_the_ramp) {
  Bench bench;
  bench.hold(0.5, {}, true);
  BOOST_TEST(norm(bench.commanded.force) > 1.9);
  bench.leave(0.195);  // the last cursor was 4 ms before
  BOOST_TEST((bench.safety.engagement == Engagement::engaged));
  bench.leave(0.15);
  BOOST_TEST(norm(bench.commanded.force) == 0.0);
  BOOST_TEST((bench.safety.cause == SafetyCause::dead_man));
  BOOST_TEST(test::metrics_of(bench.device()).at("device.released_by_timeout") == 1);
}

BOOST_AUTO_TEST_CASE(who_comes_back_must_let_go_first) {
  Bench bench;
  bench.hold(0.5, {}, true);
  bench.leave(1);
  bench.hold(0.5, {}, true);
  BOOST_TEST(norm(bench.commanded.force) == 0.0);
  BOOST_TEST(bench.state.buttons == 0);
  bench.hold(0.05, {}, false);
  bench.hold(0.5, {}, true);
  BOOST_TEST(norm(bench.commanded.force - push.force) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_cursor_that_jumps_moves_the_handle_no_faster_than_it_may) {
  Bench bench;
  bench.hold(0.5, {}, true);
  bench.cursor({0.2, 0, 0}, true);
  Vec3 before = bench.state.X_WD.p;
  for (int i = 0; i < 150; ++i) {
    bench.tick();
    BOOST_TEST(norm(bench.state.X_WD.p - before) <= 0.5e-3 + 1e-12);
    BOOST_TEST(norm(bench.state.V_WD.v) <= 0.5 + 1e-12);
    before = bench.state.X_WD.p;
  }
  BOOST_TEST((bench.safety.engagement == Engagement::engaged));
}

BOOST_AUTO_TEST_CASE(a_cursor_that_is_no_pose_is_a_fault_without_force) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Bench bench;
    bench.hold(0.5, {}, true);
    Cursor message;
    message.held = 1;
    message.X_WC.p.y = bad;
    bench.send(message);
    bench.leave(0.1);
    BOOST_TEST(norm(bench.commanded.force) == 0.0);
    BOOST_TEST((bench.safety.engagement == Engagement::fault));
    BOOST_TEST(std::isfinite(bench.state.X_WD.p.y));
  }
  Bench bench;
  Cursor message;
  message.X_WC.R = {2, 0, 0, 0};
  bench.send(message);
  bench.tick();
  BOOST_TEST(norm(bench.commanded.force) == 0.0);
}

BOOST_AUTO_TEST_CASE(ticks_allocate_nothing) {
  Bench bench;
  bench.hold(0.1, {}, true);
  const std::int64_t before = thread_heap_calls();
  bench.hold(0.2, {0.01, 0, 0}, true);
  BOOST_TEST(thread_heap_calls() == before);
}

BOOST_AUTO_TEST_CASE(a_handle_that_may_be_faster_than_the_gate_lets_it_is_refused) {
  BOOST_CHECK_THROW(Bench({{"follow_speed", 3.0}}), InputError);
  BOOST_CHECK_THROW(Bench({{"follow_angular_speed", 40.0}}), InputError);
}

BOOST_AUTO_TEST_SUITE_END()
