// The change-over of interpolation.select against its closed form.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>

#include "framework/core/check.hpp"
#include "framework/core/segment.hpp"
#include "nodes/interpolation/select.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(select_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double tau = 0.01;
constexpr Duration tick{1'000'000};

Wrench along(double x) {
  return {{x, 0, -2 * x}, {0, 0.1 * x, 0}};
}

/// A line from `value` that changes by `rate` a second, for a second.
ForceSegment line(Time begin, double value, double rate = 0) {
  return {begin, begin + Duration::from_seconds(1), {along(value), along(rate)}};
}

struct Driven {
  Driven() : node({Select::Use::first, Duration::from_seconds(tau), 1000}, context()) {
    node.first.configure({QueuePolicy::latest, 1});
    node.second.configure({QueuePolicy::latest, 1});
  }
  void use(Select::Use wanted) { node.tune({wanted, Duration::from_seconds(tau), 1000}); }
  void arrive(Input<ForceSegment>& input, const ForceSegment& segment) { input.push({now, now, sequence++}, &segment); }
  /// Steps; whether a segment was sent.
  bool step() {
    StepContext c(now);
    node.step(c);
    const bool sent = node.segment.pending() > 0;
    if (sent) shown = *static_cast<const ForceSegment*>(node.segment.pending_value(0));
    node.segment.clear_pending();
    return sent;
  }
  Select node;
  ForceSegment shown;
  Time now;
  std::uint64_t sequence = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(the_segments_of_the_input_in_use_go_through_unchanged_and_once) {
  Driven d;
  BOOST_TEST(!d.step());
  d.arrive(d.node.second, line(d.now, 5));
  BOOST_TEST(!d.step());
  for (int i = 0; i < 5; ++i) {
    const ForceSegment segment = line(d.now, i, 10);
    d.arrive(d.node.first, segment);
    BOOST_TEST(d.step());
    BOOST_TEST((d.shown.begin == segment.begin && d.shown.end == segment.end));
    for (std::size_t k = 0; k < segment.c.size(); ++k) BOOST_TEST(norm((d.shown.c[k] - segment.c[k]).force) == 0);
    d.now = d.now + tick;
    BOOST_TEST(!d.step());
  }
}

BOOST_AUTO_TEST_CASE(a_segment_states_the_trust_of_the_one_in_use) {
  Driven d;
  ForceSegment trusted = line(d.now, 1);
  trusted.trust_time = tick * 300;
  d.arrive(d.node.first, trusted);
  d.step();
  BOOST_TEST((d.shown.trust_time == trusted.trust_time));
  d.now = d.now + tick;
  d.arrive(d.node.second, line(d.now, 2));
  d.use(Select::Use::second);
  BOOST_REQUIRE(d.step());
  BOOST_TEST((d.shown.trust_time == Duration{}));
  d.now = d.now + tick;
  d.use(Select::Use::first);
  BOOST_REQUIRE(d.step());  // while it changes over
  BOOST_TEST((d.shown.trust_time == trusted.trust_time));
}

BOOST_AUTO_TEST_CASE(a_change_keeps_force_and_slope_and_decays_by_its_closed_form) {
  Driven d;
  d.arrive(d.node.first, line(d.now, 1, 20));
  d.step();
  d.now = Time{} + tick * 50;
  d.arrive(d.node.second, line(Time{}, 4, -30));
  d.use(Select::Use::second);
  const double t0 = 0.05;
  // e = F_first - F_second and its rate where the change is made.
  const double e = (1 + 20 * t0) - (4 - 30 * t0);
  const double rate = 20 + 30;
  for (int i = 0; i < 190; ++i) {
    BOOST_REQUIRE(d.step());
    BOOST_TEST((d.shown.begin == d.now));
    const double h = 1e-3 * i;
    const double b = rate + e / tau;
    const double value = (4 - 30 * (t0 + h)) + (e + b * h) * std::exp(-h / tau);
    const double slope = -30 + (rate - b * h / tau) * std::exp(-h / tau);
    BOOST_TEST(norm(evaluate(d.shown, d.now).force - along(value).force) < 1e-11);
    BOOST_TEST(norm(evaluate(d.shown, d.now).torque - along(value).torque) < 1e-12);
    BOOST_TEST(norm(evaluate_rate(d.shown, d.now).force - along(slope).force) < 1e-8);
    d.now = d.now + tick;
  }
  // After 20 time constants the new curve itself.
  d.now = Time{} + tick * 260;
  BOOST_TEST(d.step());
  BOOST_TEST(norm((d.shown.c[0] - along(4)).force) == 0);
  d.now = d.now + tick;
  BOOST_TEST(!d.step());
}

BOOST_AUTO_TEST_CASE(jumps_of_the_new_curve_are_blended_in_while_it_changes_over) {
  Driven d;
  d.arrive(d.node.first, line(d.now, 0));
  d.step();
  d.arrive(d.node.second, line(d.now, 1));
  d.use(Select::Use::second);
  d.step();
  double before = 0;
  for (int i = 1; i < 100; ++i) {
    d.now = d.now + tick;
    if (i % 10 == 0) d.arrive(d.node.second, line(d.now, i % 20 == 0 ? 1 : -1));
    const double left = evaluate(d.shown, d.now).force.x;
    d.step();
    BOOST_TEST(std::abs(evaluate(d.shown, d.now).force.x - left) < 1e-12);
    BOOST_TEST(std::abs(left - before) < 2.0 / std::exp(1) * 1e-3 / tau * 1.5);
    before = left;
  }
}

BOOST_AUTO_TEST_CASE(an_input_without_a_segment_comes_into_use_with_its_first_one) {
  Driven d;
  d.arrive(d.node.first, line(d.now, 2));
  d.step();
  d.use(Select::Use::second);
  d.now = d.now + tick;
  d.arrive(d.node.first, line(d.now, 3));
  BOOST_TEST(d.step());
  BOOST_TEST(d.shown.c[0].force.x == 3);
  d.now = d.now + tick;
  d.arrive(d.node.second, line(d.now, 7));
  BOOST_TEST(d.step());
  BOOST_TEST(std::abs(evaluate(d.shown, d.now).force.x - 3) < 1e-12);
  for (int i = 0; i < 300; ++i) {
    d.now = d.now + tick;
    d.step();
  }
  BOOST_TEST(d.shown.c[0].force.x == 7);
}

BOOST_AUTO_TEST_CASE(a_force_that_is_not_finite_goes_through_and_leaves_nothing_behind) {
  const double bad = std::numeric_limits<double>::quiet_NaN();
  Driven d;
  d.arrive(d.node.first, line(d.now, bad));
  BOOST_TEST(d.step());
  BOOST_TEST(std::isnan(d.shown.c[0].force.x));
  d.now = d.now + tick;
  d.arrive(d.node.second, line(d.now, 7));
  d.use(Select::Use::second);
  BOOST_TEST(d.step());
  BOOST_TEST(d.shown.c[0].force.x == 7);
  // In the middle of a change.
  d.arrive(d.node.first, line(d.now, 1));
  d.use(Select::Use::first);
  d.step();
  d.now = d.now + tick;
  ForceSegment spoilt = line(d.now, 1);
  spoilt.c[3].torque.y = bad;
  d.arrive(d.node.first, spoilt);
  BOOST_TEST(d.step());
  BOOST_TEST(std::isnan(d.shown.c[3].torque.y));
  d.now = d.now + tick;
  d.arrive(d.node.first, line(d.now, 2));
  BOOST_TEST(d.step());
  BOOST_TEST(d.shown.c[0].force.x == 2);
}

BOOST_AUTO_TEST_CASE(an_input_that_no_edge_ends_at_is_refused) {
  Driven d;
  BOOST_TEST(d.node.refuses({Select::Use::second, tick, 1000}).empty());
  BOOST_TEST(d.node.refuses({Select::Use::third, tick, 1000}).find("use: third") != std::string::npos);
  Select alone({Select::Use::fourth, tick, 1000}, context());
  StepContext c(Time{});
  BOOST_CHECK_THROW(alone.start(c), InputError);
}

BOOST_AUTO_TEST_SUITE_END()
