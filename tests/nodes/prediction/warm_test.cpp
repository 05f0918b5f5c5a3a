// When predictors and refitters are warm: after as many samples as they say, and from the start where they wait for
// none.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <optional>

#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/kalman.hpp"
#include "nodes/prediction/multirate.hpp"
#include "nodes/prediction/refit.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(warm_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double period_ms = 10;

Wrench force_at(int i) {
  return {{std::sin(0.3 * i), std::cos(0.17 * i), 0.1 * std::sin(0.05 * i)}, {}};
}

/// After how many samples, every 10 ms, the node is warm; 0: from the start; nothing: not within 1,000.
template <class N, class Before>
std::optional<int> samples_to_warm(N& node, Before before) {
  for (int i = 0; i < 1000; ++i) {
    const Stamp stamp = stamp_ms(period_ms * i);
    before(i, stamp);
    const Wrench force = force_at(i);
    node.force.push(stamp, &force);
    StepContext context(stamp.produced);
    node.step(context);
    if (!node.warm_since()) continue;
    // It says when that was.
    if (i > 0) BOOST_TEST((*node.warm_since() == stamp.produced));
    return *node.warm_since() == Time{} ? 0 : i + 1;
  }
  return std::nullopt;
}

template <class N>
std::optional<int> samples_to_warm(N& node) {
  return samples_to_warm(node, [](int, const Stamp&) {});
}

std::optional<int> of_refitter(const Refitter::Params& params) {
  Refitter node(params, context(false));
  node.force.configure({QueuePolicy::drop_oldest, 512});
  return samples_to_warm(node);
}

std::optional<int> of_predictor(const ArPredictor::Params& params) {
  ArPredictor node(params, context(false));
  node.force.configure({QueuePolicy::drop_oldest, 64});
  return samples_to_warm(node);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_refitter_is_warm_when_its_window_is_full) {
  auto params = default_params<Refitter>();
  params.window = 40;
  params.detrend = Detrend::none;
  BOOST_TEST(of_refitter(params).value() == 40);
  // A difference takes one sample more.
  params.detrend = Detrend::difference;
  BOOST_TEST(of_refitter(params).value() == 41);
  params.window = 2000;
  BOOST_TEST(!of_refitter(params).has_value());
}

BOOST_AUTO_TEST_CASE(a_window_of_time_is_full_when_the_time_has_passed) {
  auto params = default_params<Refitter>();
  params.window = 300;
  params.window_time = 0.5;
  params.detrend = Detrend::none;
  // Samples 0 to 51 span more than 0.5 s for the first time.
  BOOST_TEST(of_refitter(params).value() == 52);
}

BOOST_AUTO_TEST_CASE(a_recursive_fit_is_warm_when_it_holds_95_percent_of_its_weight) {
  auto params = default_params<Refitter>();
  params.method = ArMethod::rls;
  params.detrend = Detrend::none;
  for (const double forgetting : {0.95, 0.98, 0.99}) {
    params.forgetting = forgetting;
    const int samples = of_refitter(params).value();
    BOOST_TEST(samples == std::ceil(3 / (1 - forgetting) - 1e-9));
    // What is older than that many samples has the weight forgetting^n of all.
    BOOST_TEST(std::pow(forgetting, samples) < 0.05);
  }
}

BOOST_AUTO_TEST_CASE(a_predictor_with_fixed_coefficients_is_warm_from_the_start_unless_it_takes_a_mean) {
  auto params = default_params<ArPredictor>();
  params.coefficients = ArPredictor::Source::fixed;
  BOOST_TEST(of_predictor(params).value() == 0);
  params.detrend = Detrend::mean;
  params.mean_window = 50;
  BOOST_TEST(of_predictor(params).value() == 50);
}

BOOST_AUTO_TEST_CASE(a_predictor_that_waits_for_coefficients_is_warm_with_the_first_of_them) {
  ArPredictor node(default_params<ArPredictor>(), context(false));
  node.force.configure({QueuePolicy::drop_oldest, 64});
  node.coefficients.configure({QueuePolicy::latest, 1});
  const auto samples = samples_to_warm(node, [&](int i, const Stamp& stamp) {
    ArCoefficients fitted;
    fitted.force_order = 1;
    fitted.detrend = Detrend::difference;
    if (i == 17) node.coefficients.push(stamp, &fitted);
  });
  BOOST_TEST(samples.value() == 18);
}

BOOST_AUTO_TEST_CASE(what_learns_how_the_force_follows_the_device_is_warm_after_its_memory) {
  auto params = default_params<MultiratePredictor>();
  params.forgetting = 0.95;
  MultiratePredictor node(params, context(false));
  node.force.configure({QueuePolicy::drop_oldest, 64});
  node.device.configure({QueuePolicy::drop_oldest, 512});
  const auto samples = samples_to_warm(node, [&](int i, const Stamp& stamp) {
    DeviceState state;
    state.X_WD.p = {1e-3 * std::sin(0.2 * i), 0, 0};
    node.device.push(stamp, &state);
  });
  // One sample has nothing before it to be learnt from.
  BOOST_TEST(samples.value() == 61);
}

BOOST_AUTO_TEST_CASE(a_filter_that_waits_for_nothing_is_warm_from_the_start) {
  KalmanPredictor node(default_params<KalmanPredictor>(), context(false));
  node.force.configure({QueuePolicy::drop_oldest, 64});
  BOOST_TEST(samples_to_warm(node).value() == 0);
  BOOST_TEST(KalmanPredictor::declare().warm_when.empty());
  BOOST_TEST(!Refitter::declare().warm_when.empty());
}

BOOST_AUTO_TEST_SUITE_END()
