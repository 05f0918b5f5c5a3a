// The baselines: none, linear, and the low-pass against its analytic step response.
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "framework/core/segment.hpp"
#include "nodes/interpolation/linear.hpp"
#include "nodes/interpolation/lowpass.hpp"
#include "nodes/interpolation/none.hpp"
#include "tests/support/force_stream.hpp"

BOOST_AUTO_TEST_SUITE(baselines_test)

using namespace tactor;
using namespace tactor::test;

namespace {

Forecast forecast_of(double current, double predicted) {
  return {{{current, 0, 0}, {0, 0, 0.1 * current}}, {Wrench{{predicted, 0, 0}, {0, 0, 0.1 * predicted}}}, 0.01};
}

ForceSegment tick(LowPass& node, Time now) {
  StepContext c(now);
  node.step(c);
  TACTOR_DEMAND(node.segment.pending() == 1);
  const ForceSegment g = *static_cast<const ForceSegment*>(node.segment.pending_value(0));
  node.segment.clear_pending();
  return g;
}

// 1 - (1 + t / tau) exp(-t / tau): the answer of two equal poles to a step of 1.
double step_response(double t, double tau) {
  return 1 - (1 + t / tau) * std::exp(-t / tau);
}

}  // namespace

BOOST_AUTO_TEST_CASE(no_interpolation_holds_the_current_force) {
  NoInterpolation node({}, context());
  node.forecast.configure({QueuePolicy::latest, 1});
  const ForceSegment g = step_with(node, node.forecast, stamp_ms(5), forecast_of(2, 9), node.segment);
  BOOST_TEST(evaluate(g, stamp_ms(5).valid).force.x == 2.0);
  BOOST_TEST(evaluate(g, stamp_ms(500).valid).force.x == 2.0);
  BOOST_TEST(evaluate(g, stamp_ms(500).valid).torque.z == 0.2);
}

BOOST_AUTO_TEST_CASE(linear_goes_from_the_displayed_value_to_the_predicted_one_and_holds_it) {
  LinearInterpolation node({}, context());
  node.forecast.configure({QueuePolicy::latest, 1});
  step_with(node, node.forecast, stamp_ms(0), forecast_of(0, 1), node.segment);
  const ForceSegment a = step_with(node, node.forecast, stamp_ms(20), forecast_of(0, 5), node.segment);
  BOOST_TEST(std::abs(evaluate(a, stamp_ms(20).valid).force.x - 1) < 1e-12);
  BOOST_TEST(std::abs(evaluate(a, stamp_ms(30).valid).force.x - 3) < 1e-12);
  BOOST_TEST(std::abs(evaluate(a, stamp_ms(99).valid).force.x - 5) < 1e-12);
  const ForceSegment b = step_with(node, node.forecast, stamp_ms(25), forecast_of(0, 0), node.segment);
  BOOST_TEST(std::abs(evaluate(b, stamp_ms(25).valid).force.x - 2) < 1e-12);
}

BOOST_AUTO_TEST_CASE(lowpass_answers_a_step_as_two_equal_poles_do) {
  for (const double rate : {250.0, 1000.0, 4000.0}) {
    for (const double phase : {0.0, 0.00037}) {
      LowPass node({Duration::from_seconds(0.004), rate}, context());
      node.forecast.configure({QueuePolicy::latest, 1});
      const Forecast zero = forecast_of(0, 0);
      node.forecast.push(stamp_ms(0), &zero);
      const Duration h = Duration::from_rate(rate);
      Time now = Time::from_seconds(phase);
      for (int k = 0; k < 5; ++k, now = now + h) tick(node, now);
      const Forecast one = forecast_of(1, 7);
      node.forecast.push(stamp_ms(1), &one);
      const Time begin = now;
      for (int k = 0; k < 40; ++k, now = now + h) {
        const ForceSegment g = tick(node, now);
        const double t = (now - begin).seconds();
        BOOST_TEST(std::abs(evaluate(g, now).force.x - step_response(t, 0.004)) < 1e-12);
        BOOST_TEST(std::abs(evaluate(g, now).torque.z - 0.1 * step_response(t, 0.004)) < 1e-12);
        BOOST_TEST(std::abs(evaluate_rate(g, now).force.x - t / 1.6e-5 * std::exp(-t / 0.004)) < 1e-9);
        // Half-way the cubic differs from the exponential by h^4 / 384 of its fourth derivative, at most 3 / tau^4.
        const Time half = now + Duration{h.ns / 2};
        const double bound = 3.0 / 384 * std::pow(h.seconds() / 0.004, 4);
        BOOST_TEST(std::abs(evaluate(g, half).force.x - step_response((half - begin).seconds(), 0.004)) <= bound);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(lowpass_catches_up_after_ticks_that_were_missed) {
  LowPass node({Duration::from_seconds(0.004), 1000}, context());
  node.forecast.configure({QueuePolicy::latest, 1});
  const Forecast one = forecast_of(1, 1);
  node.forecast.push(stamp_ms(0), &one);
  tick(node, stamp_ms(0).valid);
  const ForceSegment g = tick(node, stamp_ms(9).valid);
  BOOST_TEST(std::abs(evaluate(g, stamp_ms(9).valid).force.x - step_response(0.009, 0.004)) < 1e-12);
}

BOOST_AUTO_TEST_CASE(lowpass_shows_a_ramp_two_time_constants_late) {
  LowPass node({Duration::from_seconds(0.004), 10000}, context());
  node.forecast.configure({QueuePolicy::latest, 1});
  ForceSegment g;
  Time now;
  for (int k = 0; k <= 1000; ++k) {
    now = Time{k * 100'000};
    const Forecast f = forecast_of(now.seconds(), 0);
    node.forecast.push({now, now, static_cast<std::uint64_t>(k)}, &f);
    g = tick(node, now);
  }
  // The input is held over a tick of 0.1 ms, which adds half of one.
  BOOST_TEST(std::abs(now.seconds() - evaluate(g, now).force.x - 0.00805) < 6e-5);
}

BOOST_AUTO_TEST_CASE(lowpass_is_silent_before_the_first_forecast) {
  LowPass node({Duration::from_seconds(0.004), 1000}, context());
  node.forecast.configure({QueuePolicy::latest, 1});
  StepContext c(Time{0});
  node.step(c);
  BOOST_TEST(node.segment.pending() == 0U);
}

BOOST_AUTO_TEST_CASE(a_force_that_is_not_finite_is_passed_on_and_forgotten) {
  const double nan = std::nan("");
  LinearInterpolation line({}, context());
  line.forecast.configure({QueuePolicy::latest, 1});
  step_with(line, line.forecast, stamp_ms(0), forecast_of(0, 1), line.segment);
  const ForceSegment bad = step_with(line, line.forecast, stamp_ms(20), forecast_of(0, nan), line.segment);
  BOOST_TEST(!is_finite(evaluate(bad, stamp_ms(21).valid)));
  const ForceSegment good = step_with(line, line.forecast, stamp_ms(40), forecast_of(0, 3), line.segment);
  BOOST_TEST(std::abs(evaluate(good, stamp_ms(40).valid).force.x - 1) < 1e-12);

  LowPass node({Duration::from_seconds(0.004), 1000}, context());
  node.forecast.configure({QueuePolicy::latest, 1});
  const auto push = [&node](double value) {
    const Forecast f = forecast_of(value, value);
    node.forecast.push(stamp_ms(0), &f);
  };
  push(1);
  for (int k = 0; k < 5; ++k) tick(node, stamp_ms(k).valid);
  push(nan);
  BOOST_TEST(!is_finite(evaluate(tick(node, stamp_ms(5).valid), stamp_ms(5).valid)));
  push(1);
  // The filter has followed its old target all the while: at 6 ms it is where one is that saw 1 from 0 on.
  const double value = evaluate(tick(node, stamp_ms(6).valid), stamp_ms(6).valid).force.x;
  BOOST_TEST(std::abs(value - step_response(0.006, 0.004)) < 1e-12);
}

BOOST_AUTO_TEST_SUITE_END()
