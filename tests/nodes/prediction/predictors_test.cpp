// Each predictor's formula on streams whose next value is known.
#include <Eigen/Dense>
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <map>
#include <string>

#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/hold.hpp"
#include "nodes/prediction/linear.hpp"
#include "nodes/prediction/linear_position.hpp"
#include "nodes/prediction/multirate.hpp"
#include "nodes/prediction/refit.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(predictors_test)

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
  BOOST_TEST(near(f.predicted_D_W[0].force, ramp(22).force));
  BOOST_TEST(near(f.predicted_D_W[0].torque, ramp(22).torque));
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
  BOOST_TEST(near(f.predicted_D_W[0].force, ramp(33).force));
  BOOST_TEST(near(f.predicted_D_W[0].torque, ramp(33).torque));
}

BOOST_AUTO_TEST_CASE(linear_holds_before_the_second_sample) {
  Driven<LinearPredictor> linear({});
  const Forecast f = linear.feed(5, ramp(5));
  BOOST_TEST(near(f.predicted_D_W[0].force, ramp(5).force));
  BOOST_TEST(f.fallback == 1);
}

BOOST_AUTO_TEST_CASE(the_same_prediction_has_two_writings) {
  ArPredictor::Params over_samples;
  over_samples.coefficients = ArPredictor::Source::fixed;
  over_samples.detrend = Detrend::none;
  over_samples.force_coefficients = {1.5, -0.5};
  ArPredictor::Params over_differences = over_samples;
  over_differences.detrend = Detrend::difference;
  over_differences.force_coefficients = {0.5};
  ArPredictor::Params about_mean = over_samples;
  about_mean.detrend = Detrend::mean;
  Driven<ArPredictor> a(over_samples);
  Driven<ArPredictor> b(over_differences);
  Driven<ArPredictor> c(about_mean);
  ArPredictor::Params defaults;
  Driven<ArPredictor> d(defaults);
  Dice draw(1);
  for (int t = 0; t < 50; ++t) {
    const Wrench w{draw.normal_vector(), draw.normal_vector()};
    const Vec3 expected = a.feed(t, w).predicted_D_W[0].force;
    const Vec3 others[] = {b.feed(t, w).predicted_D_W[0].force, c.feed(t, w).predicted_D_W[0].force,
                           d.feed(t, w).predicted_D_W[0].force};
    if (t == 0) continue;
    for (const Vec3& other : others) BOOST_TEST(near(other, expected));
  }
}

BOOST_AUTO_TEST_CASE(force_and_torque_have_coefficients_of_their_own) {
  ArPredictor::Params p;
  p.detrend = Detrend::none;
  p.force_coefficients = {0.5, 0.25};
  p.torque_coefficients = {2.0};
  Driven<ArPredictor> ar(p);
  ar.feed(0, {{4, 0, 0}, {1, 0, 0}});
  const Forecast f = ar.feed(1, {{8, 0, 0}, {3, 0, 0}});
  BOOST_TEST(f.predicted_D_W[0].force.x == 0.5 * 8 + 0.25 * 4);
  BOOST_TEST(f.predicted_D_W[0].torque.x == 6.0);
}

BOOST_AUTO_TEST_CASE(no_torque_is_told_in_a_translation_only_scene) {
  Driven<ArPredictor> ar({}, false);
  for (int t = 0; t < 5; ++t) {
    const Forecast f = ar.feed(t, ramp(t));
    BOOST_TEST(norm(f.current_D_W.torque) == 0.0);
    BOOST_TEST(norm(f.predicted_D_W[0].torque) == 0.0);
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
  refit.detrend = Detrend::none;
  refit.order = 2;
  Refitter refitter(refit, context());
  refitter.force.configure({QueuePolicy::drop_oldest, 512});
  ArPredictor::Params ar;
  Driven<ArPredictor> predictor(ar);
  predictor.node.coefficients.configure({QueuePolicy::latest, 1});
  Dice draw(2);
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
    expected = predictor.feed(t, x).predicted_D_W[0].force;
    x2 = x1;
    x1 = x;
  }
  BOOST_TEST(std::sqrt(error / judged) < 0.01 * std::sqrt(3.0) * 1.05);
  // The roots of z^2 - 1.6 z + 0.8 have the modulus sqrt(0.8).
  const auto metrics = metrics_of(refitter);
  BOOST_TEST(std::abs(metrics.at("refit.spectral_radius_median") - std::sqrt(0.8)) < 0.02);
  BOOST_TEST(metrics.at("refit.spectral_radius_max") < 1.0);
  BOOST_TEST(metrics.at("refit.unstable") == 0.0);
}

BOOST_AUTO_TEST_CASE(refits_come_once_a_period) {
  Refitter::Params p;
  p.window = 30;
  p.period = 7;
  Refitter refitter(p, context(false));
  refitter.force.configure({QueuePolicy::drop_oldest, 512});
  Dice draw(3);
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

BOOST_AUTO_TEST_CASE(contradicting_options_of_a_refitter_are_input_errors) {
  Refitter::Params p;
  p.model_structure = ModelStructure::vector;
  p.order = 9;
  BOOST_CHECK_THROW(Refitter(p, context()), InputError);
  p.order = 0;
  BOOST_CHECK_NO_THROW(Refitter(p, context()));
  p.method = ArMethod::burg;
  BOOST_CHECK_THROW(Refitter(p, context()), InputError);
  Refitter::Params rls;
  rls.method = ArMethod::rls;
  BOOST_CHECK_NO_THROW(Refitter(rls, context()));
  rls.window_time = 1;
  BOOST_CHECK_THROW(Refitter(rls, context()), InputError);
  rls.window_time = 0;
  rls.detrend = Detrend::mean;
  BOOST_CHECK_THROW(Refitter(rls, context()), InputError);
  rls.detrend = Detrend::none;
  rls.forgetting = 0.95;  // 20 samples in the end, so order 6 at most
  rls.order = 7;
  BOOST_CHECK_THROW(Refitter(rls, context()), InputError);
}

namespace {

// An axis of a quantised force: it moves, rests for 20 samples while the other axes go on, and moves again.
double quantised_force(int t, int axis) {
  constexpr double step = 0.01;
  const int phase = (t + 23 * axis) % 70;
  const double moved = t / 70 + (phase < 50 ? phase : 50) / 50.0;
  return step * std::round((2 * std::sin(3 * moved + axis) + 0.2 * std::sin(31 * moved)) / step);
}

// The coefficients of least squares over the differences of one axis up to sample `now`, weighed by
// `forgetting`^age, by a dense factorisation.
Eigen::VectorXd weighted_least_squares(int now, int axis, int order, double forgetting) {
  const auto difference = [axis](int t) { return quantised_force(t, axis) - quantised_force(t - 1, axis); };
  const int rows = now - order;
  Eigen::MatrixXd A(rows, order);
  Eigen::VectorXd b(rows);
  for (int row = 0; row < rows; ++row) {
    const int t = order + 1 + row;
    const double root_weight = std::pow(forgetting, 0.5 * (now - t));
    b(row) = root_weight * difference(t);
    for (int i = 0; i < order; ++i) A(row, i) = root_weight * difference(t - 1 - i);
  }
  return A.householderQr().solve(b);
}

Refitter::Params recursive_per_axis(int order) {
  auto params = default_params<Refitter>();
  params.method = ArMethod::rls;
  params.model_structure = ModelStructure::per_axis;
  params.detrend = Detrend::difference;
  params.order = order;
  params.forgetting = 0.97;
  return params;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_recursive_fit_of_an_axis_that_rests_goes_on_as_least_squares_does) {
  constexpr int order = 3;
  const Refitter::Params params = recursive_per_axis(order);
  Refitter refitter(params, context(false));
  refitter.force.configure({QueuePolicy::drop_oldest, 512});
  int compared = 0;
  for (int t = 0; t < 400; ++t) {
    const Wrench x{{quantised_force(t, 0), quantised_force(t, 1), quantised_force(t, 2)}, {}};
    const ArCoefficients* sent = nullptr;
    refitter.force.push(stamp_ms(10 * t), &x);
    StepContext c(stamp_ms(10 * t).valid);
    refitter.step(c);
    if (refitter.coefficients.pending() > 0) {
      sent = static_cast<const ArCoefficients*>(refitter.coefficients.pending_value(0));
    }
    if (t < 60) {
      refitter.coefficients.clear_pending();
      continue;
    }
    BOOST_REQUIRE(sent != nullptr);
    BOOST_REQUIRE(sent->force_order == order);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::VectorXd expected = weighted_least_squares(t, axis, order, params.forgetting);
      if (!is_stable({expected.data(), static_cast<std::size_t>(order)})) continue;
      ++compared;
      for (int i = 0; i < order; ++i) {
        const double error =
            std::abs(sent->force[static_cast<std::size_t>(axis * ArCoefficients::max_order + i)] - expected(i));
        BOOST_REQUIRE_MESSAGE(error < 1e-5,
                              "sample " << t << ", axis " << axis << ", phi_" << i + 1 << " is off by " << error);
      }
    }
    refitter.coefficients.clear_pending();
  }
  BOOST_TEST(compared > 900);
}

BOOST_AUTO_TEST_CASE(an_axis_without_force_does_not_keep_a_recursive_fit_from_beginning) {
  constexpr int order = 3;
  Refitter refitter(recursive_per_axis(order), context(false));
  refitter.force.configure({QueuePolicy::drop_oldest, 512});
  Dice draw(3);
  int first = 0;
  for (int t = 1; t <= 30 && first == 0; ++t) {
    const Wrench x{{0, draw.normal(), 0}, {}};
    refitter.force.push(stamp_ms(10 * t), &x);
    StepContext c(stamp_ms(10 * t).valid);
    refitter.step(c);
    if (refitter.coefficients.pending() > 0) first = t;
  }
  // Sums of weights that reach 9: from the fifth sample on, three differences after the first, 0.97^k each.
  int expected = 4;
  for (double weight = 0; weight < 3.0 * order; ++expected) weight = 0.97 * weight + 1;
  BOOST_TEST(first == expected);
}

BOOST_AUTO_TEST_CASE(a_window_of_time_is_refitted_once_it_is_full_of_time) {
  Refitter::Params p;
  p.window_time = 0.5;
  p.order = 2;
  Refitter refitter(p, context(false));
  refitter.force.configure({QueuePolicy::drop_oldest, 512});
  Dice draw(3);
  for (int t = 0; t < 100; ++t) {
    const Wrench x{draw.normal_vector(), {}};
    refitter.force.push(stamp_ms(10 * t), &x);
    StepContext c(stamp_ms(10 * t).valid);
    refitter.step(c);
    // Differences begin at 10 ms; at 520 ms the first leaves, and 51 of 20 to 520 ms are there.
    BOOST_REQUIRE((refitter.coefficients.pending() == 1) == (t >= 52));
    if (t < 52) continue;
    BOOST_TEST(static_cast<const ArCoefficients*>(refitter.coefficients.pending_value(0))->window == 51);
    refitter.coefficients.clear_pending();
  }
}

BOOST_AUTO_TEST_CASE(coefficients_on_a_grid_are_applied_at_even_times_and_carried_to_the_horizon) {
  // x_{t+1} = 2 x_t - x_{t-1} on a grid of 8 ms goes on along a line, whatever the stamps.
  Driven<ArPredictor> ar({});
  ar.node.coefficients.configure({QueuePolicy::latest, 1});
  ArCoefficients c;
  c.grid_period = 0.008;
  c.force_order = c.torque_order = 2;
  c.force[0] = c.torque[0] = 2;
  c.force[1] = c.torque[1] = -1;
  ar.node.coefficients.push(stamp_ms(0), &c);
  Dice draw(6);
  double ms = 0;
  for (int t = 0; t < 100; ++t) {
    const double interval = draw(3, 30);
    ms += interval;
    const Forecast f = ar.feed(ms, ramp(ms));
    if (t < 8) continue;
    for (int i = 0; i < f.count; ++i) {
      const Wrench& step = f.predicted_D_W[static_cast<std::size_t>(i)];
      // 16 periods of 8 ms are as far as the model is carried.
      const double ahead = std::min(interval * (i + 1), 128.0);
      BOOST_TEST(near(step.force, ramp(ms + ahead).force, 1e-6));
      BOOST_TEST(near(step.torque, ramp(ms + ahead).torque, 1e-6));
    }
  }
}

BOOST_AUTO_TEST_CASE(every_step_is_the_recursion_carried_on_and_there_are_as_many_as_asked_for) {
  ArPredictor::Params p;
  p.detrend = Detrend::none;
  p.force_coefficients = {0.5, 0.25};
  for (std::int32_t steps = 1; steps <= Forecast::capacity; ++steps) {
    p.steps = steps;
    Driven<ArPredictor> ar(p);
    LinearPredictor::Params lp;
    lp.steps = steps;
    Driven<LinearPredictor> linear(lp);
    ar.feed(0, {{4, 0, 0}, {}});
    linear.feed(0, {{4, 0, 0}, {}});
    const Forecast f = ar.feed(10, {{8, 0, 0}, {}});
    const Forecast line = linear.feed(10, {{8, 0, 0}, {}});
    BOOST_TEST(f.count == steps);
    double before = 4;
    double now = 8;
    for (std::size_t i = 0; i < Forecast::capacity; ++i) {
      const double next = 0.5 * now + 0.25 * before;
      before = now;
      now = next;
      const bool used = i < static_cast<std::size_t>(steps);
      BOOST_TEST(f.predicted_D_W[i].force.x == (used ? now : 0.0));
      BOOST_TEST(std::abs(line.predicted_D_W[i].force.x - (used ? 8 + 4 * (1.0 + static_cast<double>(i)) : 0)) < 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(products_say_what_a_coefficient_multiplies) {
  const Wrench x{{1, 2, 3}, {0.1, 0.2, 0.3}};
  ArCoefficients c;
  c.force_order = c.torque_order = 1;
  c.model_structure = ModelStructure::per_axis;
  c.force[0] = 2;
  c.force[ArCoefficients::max_order] = 3;
  c.force[2 * ArCoefficients::max_order] = 4;
  Driven<ArPredictor> per_axis({});
  per_axis.node.coefficients.configure({QueuePolicy::latest, 1});
  per_axis.node.coefficients.push(stamp_ms(0), &c);
  BOOST_TEST(near(per_axis.feed(0, x).predicted_D_W[0].force, {2, 6, 12}));
  c.model_structure = ModelStructure::vector;
  for (std::size_t i = 0; i < 9; ++i) c.force[i] = static_cast<double>(i + 1);
  Driven<ArPredictor> matrix({});
  matrix.node.coefficients.configure({QueuePolicy::latest, 1});
  matrix.node.coefficients.push(stamp_ms(0), &c);
  BOOST_TEST(near(matrix.feed(0, x).predicted_D_W[0].force, {14, 32, 50}));
}

namespace {

// Feeds a predictor that knows the device: the state of each millisecond up to 10 ms after the sample.
template <class N>
struct Handled : Driven<N> {
  explicit Handled(typename N::Params params) : Driven<N>(params) {
    this->node.device.configure({QueuePolicy::drop_oldest, 256});
  }
  static Pose path(double ms) {
    const double s = 1e-3 * ms;
    return {{0.01 * std::sin(5 * s), 0.02 * s, 0}, from_rotation_vector({0, 0, 0.5 * s})};
  }
  void see_device_until(double ms) {
    for (; device_ms <= ms; ++device_ms) {
      const DeviceState state{path(device_ms), {}, 0};
      this->node.device.push(stamp_ms(device_ms), &state);
    }
  }
  Forecast feed(double ms, const Wrench& w) {
    see_device_until(ms + 10);
    return Driven<N>::feed(ms, w);
  }
  double device_ms = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(linear_position_meets_a_spring_along_a_straight_way) {
  // A wall of 500 N/m across y and a torsion spring about z: both change in proportion to the way.
  LinearPositionPredictor::Params p;
  p.min_displacement = 1e-5;
  Handled<LinearPositionPredictor> node(p);
  const auto spring = [](double ms) { return Wrench{{0, -500 * 0.02e-3 * ms, 0}, {0, 0, -0.4 * 0.5e-3 * ms}}; };
  struct Straight {
    static Pose path(double ms) { return {{0, 0.02e-3 * ms, 0}, from_rotation_vector({0, 0, 0.5e-3 * ms})}; }
  };
  double ms = 0;
  Dice draw(1);
  for (int t = 0; t < 60; ++t) {
    ms += std::round(draw(6, 10));
    for (; node.device_ms <= ms + 10; ++node.device_ms) {
      const DeviceState state{Straight::path(node.device_ms), {}, 0};
      node.node.device.push(stamp_ms(node.device_ms), &state);
    }
    const Forecast f = node.feed(ms, spring(ms));
    if (t < 2) continue;
    BOOST_TEST(near(f.predicted_D_W[0].force, spring(ms + 1e3 * f.horizon).force, 1e-6));
    BOOST_TEST(near(f.predicted_D_W[0].torque, spring(ms + 1e3 * f.horizon).torque, 1e-6));
  }
}

BOOST_AUTO_TEST_CASE(linear_position_holds_while_the_device_has_hardly_moved_and_reaches_no_further_than_told) {
  LinearPositionPredictor::Params p;
  p.min_displacement = 1;
  p.min_rotation = 1;
  Handled<LinearPositionPredictor> still(p);
  for (int t = 0; t < 20; ++t) {
    const Forecast f = still.feed(10.0 * t, ramp(10.0 * t));
    BOOST_TEST(near(f.predicted_D_W[0].force, ramp(10.0 * t).force));
    BOOST_TEST(f.fallback == 1);
  }
  p = {};
  p.reach = 0.5;
  p.min_displacement = 1e-5;
  Handled<LinearPositionPredictor> node(p);
  Wrench before;
  for (int t = 0; t < 20; ++t) {
    const Wrench now = ramp(10.0 * t);
    const Vec3 step = node.feed(10.0 * t, now).predicted_D_W[0].force - now.force;
    if (t > 1) BOOST_TEST(norm(step) <= 0.5 * norm(now.force - before.force) + 1e-9);
    before = now;
  }
}

BOOST_AUTO_TEST_CASE(every_step_follows_the_device_as_far_as_its_way_is_known) {
  // Four steps of 10 ms, and a device whose state is known 40 ms beyond the sample.
  const auto wall = [](double ms) {
    const auto x = [](double s) { return Handled<MultiratePredictor>::path(s).p; };
    return Wrench{-300 * x(ms) - 40 * (x(ms) - x(ms - 10)), {}};
  };
  MultiratePredictor::Params p;
  p.steps = Forecast::capacity;
  Handled<MultiratePredictor> node(p);
  for (int t = 1; t < 200; ++t) {
    const double ms = 10.0 * t;
    node.see_device_until(ms + 40);
    const Forecast f = node.feed(ms, wall(ms));
    if (t <= 50) continue;
    for (std::size_t i = 0; i < f.predicted_D_W.size(); ++i) {
      const Vec3 expected = wall(ms + 10 * (1.0 + static_cast<double>(i))).force;
      const double held = norm(wall(ms).force - expected);
      BOOST_TEST(norm(f.predicted_D_W[i].force - expected) < 1e-2 * held + 1e-4, "step " << t << ", " << i);
    }
  }
}

BOOST_AUTO_TEST_CASE(multirate_learns_a_spring_and_damper_and_knows_the_force_from_the_motion) {
  // Changes of force follow those of position: dF(k) = -300 dx(k) - 40 (dx(k) - dx(k-1)), so b says all.
  for (const MultiratePredictor::Shared model_structure :
       {MultiratePredictor::Shared::axes, MultiratePredictor::Shared::per_axis}) {
    MultiratePredictor::Params p;
    p.model_structure = model_structure;
    Handled<MultiratePredictor> node(p);
    const auto wall = [](double ms) {
      const auto x = [](double s) { return Handled<MultiratePredictor>::path(s).p; };
      return Wrench{-300 * x(ms) - 40 * (x(ms) - x(ms - 10)), {}};
    };
    for (int t = 1; t < 200; ++t) {
      const double ms = 10.0 * t;
      const Forecast f = node.feed(ms, wall(ms));
      const double error = norm(f.predicted_D_W[0].force - wall(ms + 10).force);
      const double held = norm(wall(ms).force - wall(ms + 10).force);
      if (t > 50) BOOST_TEST(error < 1e-2 * held, "step " << t << ": " << error << " for " << held);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
