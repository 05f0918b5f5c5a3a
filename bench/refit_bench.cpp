// What a refit and a prediction cost, each beside its plain alternative, for a window of 300 samples of three axes.
#include <benchmark/benchmark.h>

#include <Eigen/Cholesky>
#include <vector>

#include "nodes/interpolation/bspline.hpp"
#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/ar_coefficients.hpp"
#include "nodes/prediction/autoregression.hpp"
#include "nodes/prediction/hold.hpp"
#include "nodes/prediction/kalman.hpp"
#include "nodes/prediction/linear.hpp"
#include "nodes/prediction/linear_position.hpp"
#include "nodes/prediction/multirate.hpp"
#include "nodes/prediction/refit.hpp"
#include "nodes/prediction/sample_window.hpp"
#include "tests/support/force_stream.hpp"

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr std::size_t window = 300;

std::vector<Vec3> signal(std::size_t n) {
  Dice draw(1);
  std::vector<Vec3> x(n);
  for (std::size_t t = 2; t < n; ++t) x[t] = 1.2 * x[t - 1] - 0.5 * x[t - 2] + draw.normal_vector();
  return x;
}

// What a physics force looks like: a slow swing, a texture of the signal above, and noise.
std::vector<Wrench> textured(std::size_t n) {
  Dice draw(2);
  const std::vector<Vec3> texture = signal(n);
  std::vector<Wrench> w;
  for (std::size_t t = 0; t < n; ++t) {
    const double s = 0.05 * static_cast<double>(t);
    const Vec3 force = Vec3{2 * std::sin(s), std::cos(0.7 * s), 1} + 0.05 * texture[t] + draw.normal_vector(0.02);
    w.push_back({force, 0.01 * force});
  }
  return w;
}

std::vector<double> lags(int order) {
  std::vector<double> r(static_cast<std::size_t>(order) + 1);
  autocovariance(signal(window), {}, r);
  return r;
}

void levinson(benchmark::State& state) {
  const int order = static_cast<int>(state.range(0));
  const std::vector<double> r = lags(order);
  for (auto _ : state) benchmark::DoNotOptimize(fit_yule_walker(r, {.max_order = order}));
}
BENCHMARK(levinson)->Arg(3)->Arg(10)->Arg(20);

void levinson_by_final_prediction_error(benchmark::State& state) {
  const int order = static_cast<int>(state.range(0));
  const std::vector<double> r = lags(order);
  for (auto _ : state) {
    benchmark::DoNotOptimize(fit_yule_walker(r, {.max_order = order, .rule = OrderRule::fpe, .samples = window}));
  }
}
BENCHMARK(levinson_by_final_prediction_error)->Arg(3)->Arg(10)->Arg(20);

void dense_cholesky(benchmark::State& state) {
  const auto order = static_cast<Eigen::Index>(state.range(0));
  const std::vector<double> r = lags(static_cast<int>(order));
  Eigen::MatrixXd R(order, order);
  Eigen::VectorXd b(order);
  Eigen::VectorXd phi(order);
  Eigen::LLT<Eigen::MatrixXd> llt(order);
  for (auto _ : state) {
    for (Eigen::Index i = 0; i < order; ++i) {
      for (Eigen::Index j = 0; j < order; ++j) R(i, j) = r[static_cast<std::size_t>(std::abs(i - j))];
      R(i, i) *= 1 + 1e-9;
      b(i) = r[static_cast<std::size_t>(i) + 1];
    }
    llt.compute(R);
    phi = llt.solve(b);
    benchmark::DoNotOptimize(phi.data());
  }
}
BENCHMARK(dense_cholesky)->Arg(3)->Arg(10)->Arg(20);

void autocovariance_from_scratch(benchmark::State& state) {
  const std::vector<Vec3> x = signal(window);
  std::vector<double> r(static_cast<std::size_t>(state.range(0)) + 1);
  for (auto _ : state) {
    autocovariance(x, {}, r);
    benchmark::DoNotOptimize(r.data());
  }
}
BENCHMARK(autocovariance_from_scratch)->Arg(3)->Arg(10)->Arg(20);

void autocovariance_sliding(benchmark::State& state) {
  const std::vector<Vec3> x = signal(4096);
  std::vector<double> r(static_cast<std::size_t>(state.range(0)) + 1);
  AutocovarianceWindow sliding(window, r.size(), false);
  for (const Vec3& v : x) sliding.push(v);
  std::size_t i = 0;
  for (auto _ : state) {
    sliding.push(x[i++ % x.size()]);
    sliding.covariances(r);
    benchmark::DoNotOptimize(r.data());
  }
}
BENCHMARK(autocovariance_sliding)->Arg(3)->Arg(10)->Arg(20);

// One message into a node and out again, as an engine steps it.
template <class N, class In, class Out>
void step_node(benchmark::State& state, N& node, Input<In>& in, Output<Out>& out, const std::vector<In>& messages) {
  in.configure({QueuePolicy::drop_oldest, 64});
  std::int64_t t = 0;
  for (auto _ : state) {
    const Stamp stamp{{t * 10'000'000}, {t * 10'000'000}, static_cast<std::uint64_t>(t)};
    in.push(stamp, &messages[static_cast<std::size_t>(t) % messages.size()]);
    StepContext c(stamp.produced);
    node.step(c);
    out.clear_pending();
    ++t;
  }
}

std::vector<Wrench> wrenches() {
  std::vector<Wrench> w;
  for (const Vec3& v : signal(4096)) w.push_back({v, 0.01 * v});
  return w;
}

Refitter::Params refit_params(const benchmark::State& state) {
  Refitter::Params p;
  p.method = static_cast<ArMethod>(state.range(0));
  p.model_structure = static_cast<ModelStructure>(state.range(1));
  p.detrend = static_cast<Detrend>(state.range(2));
  p.window = static_cast<std::int32_t>(state.range(3));
  return p;
}

// RMS one-step error of the refitted predictor over that of a hold, on `textured`, after 600 samples.
double error_over_hold(const Refitter::Params& params) {
  Refitter refitter(params, context());
  ArPredictor::Params ar;
  ar.force_max = ar.torque_max = 100;
  ArPredictor predictor(ar, context());
  refitter.force.configure({QueuePolicy::drop_oldest, 64});
  predictor.force.configure({QueuePolicy::drop_oldest, 64});
  predictor.coefficients.configure({QueuePolicy::latest, 1});
  const std::vector<Wrench> forces = textured(3000);
  double error = 0;
  double held = 0;
  for (std::size_t t = 0; t + 1 < forces.size(); ++t) {
    const Stamp stamp = stamp_ms(10.0 * static_cast<double>(t));
    refitter.force.push(stamp, &forces[t]);
    StepContext c(stamp.produced);
    refitter.step(c);
    if (refitter.coefficients.pending() > 0) {
      predictor.coefficients.push(stamp, refitter.coefficients.pending_value(0));
      refitter.coefficients.clear_pending();
    }
    const Vec3 predicted =
        step_with(predictor, predictor.force, stamp, forces[t], predictor.forecast).predicted_D_W[0].force;
    if (t < 600) continue;
    const Vec3 e = forces[t + 1].force - predicted;
    const Vec3 h = forces[t + 1].force - forces[t].force;
    error += dot(e, e);
    held += dot(h, h);
  }
  return std::sqrt(error / held);
}

void refit_node(benchmark::State& state) {
  const Refitter::Params p = refit_params(state);
  Refitter node(p, context());
  step_node(state, node, node.force, node.coefficients, textured(4096));
  Report report;
  report.ask(node, "refit", Refitter::declare().metrics);
  for (const auto& [name, value] : report.metrics()) {
    if (name == "refit.force_order_mean") state.counters["order"] = value;
    if (name == "refit.spectral_radius_max") state.counters["radius"] = value;
  }
  state.counters["error_over_hold"] = error_over_hold(p);
}
// Force and torque; 20 orders by final prediction error (8 for vectors). Methods: 0 Yule-Walker, 1 Burg, 2 covariance,
// 3 recursion.
BENCHMARK(refit_node)
    ->ArgNames({"method", "model_structure", "detrend", "window"})
    ->ArgsProduct({{0, 1, 2, 3}, {0, 1}, {0, 2}, {300}})
    ->ArgsProduct({{0}, {2}, {0, 2}, {300}})
    ->ArgsProduct({{0, 1, 2}, {0}, {1}, {300}})
    ->ArgsProduct({{0, 1, 2}, {0}, {2}, {60}});

// A prediction by each predictor that needs no refitter.
template <class N>
void predictor_node(benchmark::State& state) {
  typename N::Params p;
  p.force_max = 100;
  p.torque_max = 100;
  N node(p, context());
  if constexpr (requires { node.device; }) {
    node.device.configure({QueuePolicy::drop_oldest, 256});
    node.force.configure({QueuePolicy::drop_oldest, 64});
    const std::vector<Wrench> forces = wrenches();
    std::int64_t t = 0;
    for (auto _ : state) {
      for (int ms = 0; ms < 10; ++ms) {
        const double s = 1e-3 * static_cast<double>(10 * t + ms);
        const DeviceState device{
            {{0.01 * std::sin(s), 0.01 * std::cos(s), 0}, from_rotation_vector({0.1 * std::sin(s), 0, 0})}, {}, 0};
        node.device.push(stamp_ms(1e3 * s), &device);
      }
      const Stamp stamp = stamp_ms(10.0 * static_cast<double>(t), static_cast<std::uint64_t>(t));
      node.force.push(stamp, &forces[static_cast<std::size_t>(t) % forces.size()]);
      StepContext c(stamp.produced);
      node.step(c);
      node.forecast.clear_pending();
      ++t;
    }
  } else {
    step_node(state, node, node.force, node.forecast, wrenches());
  }
}
BENCHMARK(predictor_node<HoldPredictor>);
BENCHMARK(predictor_node<LinearPredictor>);
BENCHMARK(predictor_node<KalmanPredictor>);
BENCHMARK(predictor_node<LinearPositionPredictor>);
BENCHMARK(predictor_node<MultiratePredictor>);

void predict_node(benchmark::State& state) {
  ArPredictor::Params p;
  p.force_max = 100;
  p.torque_max = 100;
  p.force_coefficients.assign(static_cast<std::size_t>(state.range(0)), 0.01);
  p.torque_coefficients = p.force_coefficients;
  ArPredictor node(p, context());
  step_node(state, node, node.force, node.forecast, wrenches());
}
BENCHMARK(predict_node)->Arg(3)->Arg(10)->Arg(20);

void bspline_node(benchmark::State& state) {
  BSpline node({}, context());
  std::vector<Forecast> forecasts;
  for (const Wrench& w : wrenches()) forecasts.push_back({w, {w}, 0.01});
  step_node(state, node, node.forecast, node.segment, forecasts);
}
BENCHMARK(bspline_node);

}  // namespace
