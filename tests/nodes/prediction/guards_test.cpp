// Bad and hostile input: whatever comes, the prediction is finite, within the device's limits, and right again soon.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>

#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/refit.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/hostile_wrench.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(guards_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double force_max = 8;
constexpr double torque_max = 0.5;
constexpr int window = 60;

// A refitter and a predictor, wired as a graph wires them.
struct Chain {
  explicit Chain(Detrend detrend, int order = 0, bool torque = true)
      : refitter(refit_params(detrend, order), context(torque)), predictor(ar_params(detrend), context(torque)) {
    refitter.force.configure({QueuePolicy::drop_oldest, 512});
    predictor.force.configure({QueuePolicy::drop_oldest, 64});
    predictor.coefficients.configure({QueuePolicy::latest, 1});
  }
  static Refitter::Params refit_params(Detrend detrend, int order) {
    Refitter::Params p;
    p.window = window;
    p.order = order;
    p.detrend = detrend;
    return p;
  }
  static ArPredictor::Params ar_params(Detrend detrend) {
    ArPredictor::Params p;
    p.force_max = force_max;
    p.torque_max = torque_max;
    p.detrend = detrend;
    p.mean_window = window;
    return p;
  }
  Forecast feed(const Wrench& w) {
    const Stamp stamp = stamp_ms(10.0 * time++);
    refitter.force.push(stamp, &w);
    StepContext c(stamp.produced);
    refitter.step(c);
    if (refitter.coefficients.pending() > 0) {
      predictor.coefficients.push(stamp, refitter.coefficients.pending_value(0));
      refitter.coefficients.clear_pending();
    }
    return step_with(predictor, predictor.force, stamp, w, predictor.forecast);
  }
  std::map<std::string, double> metrics() const {
    Report report = report_of(predictor);
    report.ask(refitter, "refitter", Refitter::declare().metrics);
    return metrics_of(report);
  }
  int time = 0;
  Refitter refitter;
  ArPredictor predictor;
};

bool displayable(const Wrench& w) {
  return is_finite(w) && norm(w.force) <= force_max * (1 + 1e-12) && norm(w.torque) <= torque_max * (1 + 1e-12);
}

}  // namespace

BOOST_AUTO_TEST_CASE(no_prediction_is_beyond_the_device_whatever_comes) {
  for (int kind = 0; kind < hostile_kinds; ++kind) {
    for (const Detrend detrend : {Detrend::none, Detrend::mean, Detrend::difference}) {
      for (const int order : {0, 3, 20}) {
        Dice draw(static_cast<std::uint64_t>(kind) + 1);
        Chain chain(detrend, order);
        for (int t = 0; t < 1500; ++t) {
          const Forecast f = chain.feed(hostile(kind, t, draw));
          BOOST_REQUIRE_MESSAGE(displayable(f.predicted_D_W[0]) && is_finite(f.current_D_W),
                                "kind " << kind << ", order " << order << ", step " << t);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(one_window_after_trouble_predictions_are_as_if_nothing_had_been) {
  for (int kind = 1; kind < hostile_kinds; ++kind) {
    for (const Detrend detrend : {Detrend::none, Detrend::mean, Detrend::difference}) {
      Dice draw(7);
      Dice noise_a(8);
      Dice noise_b(8);
      Chain troubled(detrend, 3);
      Chain calm(detrend, 3);
      for (int t = 0; t < 200; ++t) {
        troubled.feed(hostile(kind, t, draw));
        calm.feed({});
      }
      for (int t = 0; t < 200; ++t) {
        Wrench w{{std::sin(0.2 * t), 2, 0}, {0, 0.1, 0}};
        w.force += noise_a.normal_vector(0.01);
        w.torque += noise_b.normal_vector(0.01);
        const Vec3 a = troubled.feed(w).predicted_D_W[0].force;
        const Vec3 b = calm.feed(w).predicted_D_W[0].force;
        if (t > window + 2) BOOST_REQUIRE_MESSAGE(norm(a - b) < 1e-6, "kind " << kind << ", step " << t);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_sample_that_is_not_finite_is_left_out_and_counted_once) {
  for (const Detrend detrend : {Detrend::none, Detrend::mean, Detrend::difference}) {
    Dice draw(3);
    Chain with(detrend, 3);
    Chain without(detrend, 3);
    for (int t = 0; t < 300; ++t) {
      const Wrench w{draw.normal_vector(), draw.normal_vector(0.01)};
      const Forecast a = with.feed(w);
      const Forecast b = without.feed(w);
      BOOST_REQUIRE(norm(a.predicted_D_W[0].force - b.predicted_D_W[0].force) == 0.0);
      if (t == 150) {
        const Forecast bad = with.feed({{0, std::nan(""), 0}, {}});
        BOOST_TEST(norm(bad.current_D_W.force - w.force) == 0.0);
        BOOST_TEST(bad.fallback == 1);
      }
    }
    BOOST_TEST(with.metrics()["prediction.rejected_samples"] == 1.0);
    BOOST_TEST(with.metrics()["refit.rejected_samples"] == 1.0);
  }
}

BOOST_AUTO_TEST_CASE(a_force_of_zero_is_held) {
  for (const Detrend detrend : {Detrend::none, Detrend::mean, Detrend::difference}) {
    Chain chain(detrend);
    for (int t = 0; t < 200; ++t) BOOST_TEST(norm(chain.feed({}).predicted_D_W[0].force) == 0.0);
    auto metrics = chain.metrics();
    BOOST_TEST(metrics["refit.rejected"] > 0.0);
    BOOST_TEST(metrics["fallbacks"] > 0.0);
  }
}

BOOST_AUTO_TEST_CASE(a_constant_force_stays_constant_about_the_mean_and_over_differences) {
  for (const Detrend detrend : {Detrend::mean, Detrend::difference}) {
    Chain chain(detrend);
    Dice draw(4);
    // Noise first, so that coefficients were fitted before the force turned constant.
    for (int t = 0; t < 100; ++t) chain.feed({draw.normal_vector(), {}});
    const Vec3 constant{3.0, -1.1, 0.7};
    for (int t = 0; t < 300; ++t) {
      const Vec3 predicted = chain.feed({constant, {}}).predicted_D_W[0].force;
      if (t > window + 20) BOOST_TEST(norm(predicted - constant) < 1e-9);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_constant_force_sags_as_printed_in_the_paper_by_less_than_a_window_allows) {
  // r_1 / r_0 = (N - 1) / N for a constant, so the prediction of order 1 is short by a share 1 / N.
  Chain chain(Detrend::none, 1);
  Vec3 predicted;
  for (int t = 0; t < 200; ++t) predicted = chain.feed({{3, 0, 0}, {}}).predicted_D_W[0].force;
  BOOST_TEST(std::abs(predicted.x - 3.0 * (window - 1) / window) < 1e-6);
}

BOOST_AUTO_TEST_CASE(warm_up_is_counted_apart_from_fallbacks) {
  ArPredictor::Params p = Chain::ar_params(Detrend::none);
  p.force_coefficients = {0.5, 0.3, 0.2, 0.1};
  ArPredictor ar(p, context(false));
  ar.force.configure({QueuePolicy::drop_oldest, 8});
  for (int t = 0; t < 10; ++t) {
    const Forecast f = step_with(ar, ar.force, stamp_ms(t), {{1, 0, 0}, {}}, ar.forecast);
    BOOST_TEST((f.fallback == 1) == (t < 3));
  }
  auto metrics = metrics_of(ar);
  BOOST_TEST(metrics["prediction.warm_up"] == 3.0);
  BOOST_TEST(metrics["fallbacks"] == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
