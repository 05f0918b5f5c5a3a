// What a refit and a prediction cost, each beside its plain alternative, for a window of 300 samples of three axes.
#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <vector>

#include "nodes/interpolation/bspline.hpp"
#include "nodes/prediction/ar.hpp"
#include "nodes/prediction/autoregression.hpp"
#include "nodes/prediction/refit.hpp"
#include "nodes/prediction/sample_window.hpp"
#include "tests/nodes/force_stream.hpp"

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr std::size_t window = 300;

std::vector<Vec3> signal(std::size_t n) {
  Draw draw(1);
  std::vector<Vec3> x(n);
  for (std::size_t t = 2; t < n; ++t) x[t] = 1.2 * x[t - 1] - 0.5 * x[t - 2] + draw.normal_vector();
  return x;
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
    benchmark::DoNotOptimize(fit_yule_walker(r, {.max_order = order, .by_fpe = true, .samples = window}));
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

void refit_node(benchmark::State& state) {
  Refitter::Params p;
  p.max_order = static_cast<std::int32_t>(state.range(0));
  p.remove = static_cast<Removal>(state.range(1));
  Refitter node(p, context());
  step_node(state, node, node.force, node.coefficients, wrenches());
}
BENCHMARK(refit_node)->ArgNames({"max_order", "removal"})->ArgsProduct({{3, 10, 20}, {0, 1, 2}});

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
  for (const Wrench& w : wrenches()) forecasts.push_back({w, w, 0.01});
  step_node(state, node, node.forecast, node.segment, forecasts);
}
BENCHMARK(bspline_node);

}  // namespace
