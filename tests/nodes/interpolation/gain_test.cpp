// The factor of interpolation.gain against its closed form, and that nothing steps where it changes.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/interpolation/gain.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(gain_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr Duration gain_tick{1'000'000};
constexpr double gain_ramp = 0.05;

struct Scaled {
  explicit Scaled(double factor) : node({factor, Duration::from_seconds(gain_ramp), 1000}, context()) {
    node.force.configure({QueuePolicy::latest, 1});
  }
  void set(double factor) { node.tune({factor, Duration::from_seconds(gain_ramp), 1000}); }
  void arrive(const ForceSegment& segment) { node.force.push({now, now, sequence++}, &segment); }
  bool step() {
    StepContext c(now);
    node.step(c);
    const bool sent = node.segment.pending() > 0;
    if (sent) shown = *static_cast<const ForceSegment*>(node.segment.pending_value(0));
    node.segment.clear_pending();
    now = now + gain_tick;
    return sent;
  }
  Gain node;
  ForceSegment shown;
  Time now;
  std::uint64_t sequence = 0;
};

/// 3 N, rising by 2 N/s, for ten seconds.
ForceSegment rising() {
  return {Time{}, Time::from_seconds(10), {Wrench{{3, 0, -1}, {0, 0.1, 0}}, Wrench{{20, 0, 0}, {}}}};
}

}  // namespace

BOOST_AUTO_TEST_CASE(between_changes_a_segment_is_scaled_and_sent_once) {
  Scaled d(0.25);
  BOOST_TEST(!d.step());
  d.arrive(rising());
  BOOST_TEST(d.step());
  BOOST_TEST(!d.step());
  const Time t = Time::from_seconds(2.5);
  BOOST_TEST(evaluate(d.shown, t).force.x == 2.0);
  BOOST_TEST(evaluate(d.shown, t).force.z == -0.25);
  BOOST_TEST(evaluate(d.shown, t).torque.y == 0.025);
}

BOOST_AUTO_TEST_CASE(a_new_factor_is_reached_along_the_smooth_step) {
  Scaled d(0);
  d.arrive(rising());
  d.step();
  d.set(2);
  const Time begin = d.now;
  double before = 0, steepest = 0;
  for (int i = 0; i < 80; ++i) {
    const bool sent = d.step();
    BOOST_TEST(sent == (i <= 50));
    // At the tick, and in the middle of the one that follows.
    for (const double part : {0.0, 0.5}) {
      const Time t = d.now - gain_tick + Duration::from_seconds(part * 1e-3);
      const double s = std::clamp((t - begin).seconds() / gain_ramp, 0.0, 1.0);
      const double g = 2 * s * s * (3 - 2 * s);
      const double force = evaluate(d.shown, t).force.x;
      BOOST_TEST(std::abs(force - g * (3 + 2 * t.seconds())) < 1e-4);
      steepest = std::max(steepest, std::abs(force - before) / 0.5e-3);
      before = force;
    }
  }
  // 1.5 times the change over the ramp, and what the force itself does.
  BOOST_TEST(steepest < 1.5 * 2 * 3.3 / gain_ramp + 2 * 2 + 1);
  BOOST_TEST(evaluate(d.shown, Time::from_seconds(5)).force.x == 26);
}

BOOST_AUTO_TEST_CASE(a_change_during_a_change_goes_on_from_where_it_is) {
  Scaled d(1);
  d.arrive(rising());
  d.step();
  d.set(0);
  for (int i = 0; i < 20; ++i) d.step();
  const double there = evaluate(d.shown, d.now).force.x;
  d.set(1.5);
  d.step();
  BOOST_TEST(std::abs(evaluate(d.shown, d.now - gain_tick).force.x - there) < 1e-9);
  for (int i = 0; i < 60; ++i) d.step();
  BOOST_TEST(evaluate(d.shown, Time::from_seconds(1)).force.x == 7.5);
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_goes_on_to_the_gate_also_when_muted) {
  Scaled d(0);
  ForceSegment bad = rising();
  bad.c[0].force.y = std::numeric_limits<double>::quiet_NaN();
  d.arrive(bad);
  BOOST_TEST(d.step());
  BOOST_TEST(std::isnan(evaluate(d.shown, d.now).force.y));
}

BOOST_AUTO_TEST_CASE(the_trust_time_goes_through) {
  Scaled d(1);
  ForceSegment segment = rising();
  segment.trust_time = Duration{250'000'000};
  d.arrive(segment);
  d.step();
  d.set(0.5);
  for (int i = 0; i < 80; ++i) {
    d.step();
    BOOST_TEST((d.shown.trust_time == segment.trust_time));
  }
}

BOOST_AUTO_TEST_CASE(steps_in_and_after_a_change_allocate_nothing, *boost::unit_test::precondition(heap_is_counted)) {
  Scaled d(1);
  d.arrive(rising());
  d.step();
  d.set(0.5);
  const std::int64_t before = thread_heap_calls();
  for (int i = 0; i < 80; ++i) d.step();
  BOOST_TEST(thread_heap_calls() == before);
}

BOOST_AUTO_TEST_SUITE_END()
