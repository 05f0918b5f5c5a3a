// Each predictor's formula on streams whose next value is known.
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/hold.hpp"
#include "nodes/prediction/linear.hpp"
#include "nodes/prediction/refit.hpp"
#include "tests/nodes/force_stream.hpp"

using namespace tactor;
using namespace tactor::test;

namespace {

template <class N>
struct Driven {
  explicit Driven(typename N::Params params, bool torque = true) : node(limits(params), context(torque)) {
    node.force.configure({QueuePolicy::drop_oldest, 8});
  }
  static typename N::Params limits(typename N::Params params) {
    params.force_max = 1e3;
    params.torque_max = 1e3;
    return params;
  }
  Forecast feed(double ms, const Wrench& w) { return step_with(node, node.force, stamp_ms(ms), w, node.forecast); }
  N node;
};

Wrench ramp(double ms) {
  return {{0.1 * ms, 1, -0.2 * ms}, {0, 0.01 * ms, 2}};
}

bool near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  return norm(a - b) <= tolerance;
}

}  // namespace

BOOST_AUTO_TEST_CASE(hold_expects_the_current_force_and_tells_the_last_interval) {
  Driven<HoldPredictor> hold({});
  hold.feed(10, ramp(10));
  const Forecast f = hold.feed(22, ramp(22));
  BOOST_TEST(near(f.predicted_D_W.force, ramp(22).force));
  BOOST_TEST(near(f.predicted_D_W.torque, ramp(22).torque));
  BOOST_TEST(std::abs(f.horizon - 0.012) < 1e-12);
  BOOST_TEST(f.fallback == 0);
}

BOOST_AUTO_TEST_CASE(the_period_may_be_a_mean_and_pauses_are_cut) {
  PeriodOptions options{.period_estimate = PeriodMode::mean, .period_count = 3};
  PeriodEstimate period(options);
  BOOST_TEST(period.value().ns == options.period_initial.ns);
  for (const std::int64_t ms : {0, 100, 110, 116, 130, 130}) period.update({ms * 1'000'000});
  BOOST_TEST(period.value().ns == 10'000'000);
  period.update({5'000'000'000});
  BOOST_TEST(period.value().ns == 40'000'000);  // (6 + 14 + 100) / 3 ms
}

BOOST_AUTO_TEST_CASE(linear_meets_a_ramp_on_uneven_stamps) {
  Driven<LinearPredictor> linear({});
  linear.feed(0, ramp(0));
  linear.feed(7, ramp(7));
  const Forecast f = linear.feed(20, ramp(20));
  BOOST_TEST(near(f.predicted_D_W.force, ramp(33).force));
  BOOST_TEST(near(f.predicted_D_W.torque, ramp(33).torque));
}

BOOST_AUTO_TEST_CASE(linear_holds_before_the_second_sample) {
  Driven<LinearPredictor> linear({});
  const Forecast f = linear.feed(5, ramp(5));
  BOOST_TEST(near(f.predicted_D_W.force, ramp(5).force));
  BOOST_TEST(f.fallback == 1);
}

BOOST_AUTO_TEST_CASE(the_same_prediction_has_two_writings) {
  ArPredictor::Params over_samples;
  over_samples.coefficients = ArPredictor::Source::fixed;
  over_samples.remove = Removal::none;
  over_samples.force_coefficients = {1.5, -0.5};
  ArPredictor::Params over_differences = over_samples;
  over_differences.remove = Removal::difference;
  over_differences.force_coefficients = {0.5};
  ArPredictor::Params about_mean = over_samples;
  about_mean.remove = Removal::mean;
  Driven<ArPredictor> a(over_samples);
  Driven<ArPredictor> b(over_differences);
  Driven<ArPredictor> c(about_mean);
  ArPredictor::Params defaults;
  Driven<ArPredictor> d(defaults);
  Draw draw(1);
  for (int t = 0; t < 50; ++t) {
    const Wrench w{draw.normal_vector(), draw.normal_vector()};
    const Vec3 expected = a.feed(t, w).predicted_D_W.force;
    const Vec3 others[] = {b.feed(t, w).predicted_D_W.force, c.feed(t, w).predicted_D_W.force,
                           d.feed(t, w).predicted_D_W.force};
    if (t == 0) continue;
    for (const Vec3& other : others) BOOST_TEST(near(other, expected));
  }
}

BOOST_AUTO_TEST_CASE(force_and_torque_have_coefficients_of_their_own) {
  ArPredictor::Params p;
  p.remove = Removal::none;
  p.force_coefficients = {0.5, 0.25};
  p.torque_coefficients = {2.0};
  Driven<ArPredictor> ar(p);
  ar.feed(0, {{4, 0, 0}, {1, 0, 0}});
  const Forecast f = ar.feed(1, {{8, 0, 0}, {3, 0, 0}});
  BOOST_TEST(f.predicted_D_W.force.x == 0.5 * 8 + 0.25 * 4);
  BOOST_TEST(f.predicted_D_W.torque.x == 6.0);
}

BOOST_AUTO_TEST_CASE(no_torque_is_told_in_a_translation_only_scene) {
  Driven<ArPredictor> ar({}, false);
  for (int t = 0; t < 5; ++t) {
    const Forecast f = ar.feed(t, ramp(t));
    BOOST_TEST(norm(f.current_D_W.torque) == 0.0);
    BOOST_TEST(norm(f.predicted_D_W.torque) == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(too_many_coefficients_are_an_input_error) {
  ArPredictor::Params p;
  p.force_coefficients.assign(33, 0.1);
  BOOST_CHECK_THROW(Driven<ArPredictor>{p}, InputError);
}

BOOST_AUTO_TEST_CASE(an_order_above_a_third_of_the_window_is_an_input_error) {
  Refitter::Params p;
  p.window = 30;
  p.order = 11;
  BOOST_CHECK_THROW(Refitter(p, context()), InputError);
}

BOOST_AUTO_TEST_CASE(coefficients_are_ignored_where_they_are_fixed) {
  const NodeInfo info = ArPredictor::declare();
  std::vector<ParamValue> values;
  for (const ParamInfo& p : info.params) values.push_back(p.default_value.value());
  BOOST_TEST(info.input("coefficients")->ignored(values).empty());
  values[info.param("coefficients").value()] = std::string("fixed");
  BOOST_TEST(info.input("coefficients")->ignored(values) == "the coefficients are fixed");
}

BOOST_AUTO_TEST_CASE(a_refitted_predictor_follows_a_known_process) {
  // x_{t+1} = 1.6 x_t - 0.8 x_{t-1} + noise of 0.01: the best one-step error is the noise.
  Refitter::Params refit;
  refit.remove = Removal::none;
  refit.order = 2;
  Refitter refitter(refit, context());
  refitter.force.configure({QueuePolicy::drop_oldest, 512});
  ArPredictor::Params ar;
  Driven<ArPredictor> predictor(ar);
  predictor.node.coefficients.configure({QueuePolicy::latest, 1});
  Draw draw(2);
  Wrench x1;
  Wrench x2;
  Vec3 expected;
  double error = 0;
  int judged = 0;
  for (int t = 0; t < 3000; ++t) {
    Wrench x = 1.6 * x1 - 0.8 * x2;
    x.force += draw.normal_vector(0.01);
    x.torque += draw.normal_vector(0.01);
    if (t > 600) {
      error += dot(x.force - expected, x.force - expected);
      ++judged;
    }
    refitter.force.push(stamp_ms(t), &x);
    StepContext c(stamp_ms(t).valid);
    refitter.step(c);
    BOOST_TEST((refitter.coefficients.pending() == 1) == (t >= 299));
    if (refitter.coefficients.pending() > 0) {
      const auto* phi = static_cast<const ArCoefficients*>(refitter.coefficients.pending_value(0));
      predictor.node.coefficients.push(stamp_ms(t), phi);
      refitter.coefficients.clear_pending();
    }
    expected = predictor.feed(t, x).predicted_D_W.force;
    x2 = x1;
    x1 = x;
  }
  BOOST_TEST(std::sqrt(error / judged) < 0.01 * std::sqrt(3.0) * 1.05);
}

BOOST_AUTO_TEST_CASE(refits_come_once_a_period) {
  Refitter::Params p;
  p.window = 30;
  p.period = 7;
  Refitter refitter(p, context(false));
  refitter.force.configure({QueuePolicy::drop_oldest, 512});
  Draw draw(3);
  int sent = 0;
  for (int t = 0; t < 100; ++t) {
    const Wrench x{draw.normal_vector(), {}};
    refitter.force.push(stamp_ms(t), &x);
    StepContext c(stamp_ms(t).valid);
    refitter.step(c);
    sent += static_cast<int>(refitter.coefficients.pending());
    refitter.coefficients.clear_pending();
  }
  // 30 differences are there from sample 31 on: at samples 31, 38, ..., 94.
  BOOST_TEST(sent == 10);
}
