// Burg, least squares, recursion, Whittle and the trend filter against hand-worked values, dense solutions and numpy.
#include <Eigen/LU>
#include <Eigen/QR>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "nodes/prediction/ar_estimator.hpp"
#include "nodes/prediction/burg.hpp"
#include "nodes/prediction/trend_filter.hpp"
#include "nodes/prediction/uniform_grid.hpp"
#include "nodes/prediction/whittle.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/hostile_wrench.hpp"

BOOST_AUTO_TEST_SUITE(estimators_test)

using namespace tactor;
using namespace tactor::test;

namespace {

using Signal = std::vector<Vec3>;

ArFit fit(ArMethod method, const Signal& x, int order, double forgetting = 1) {
  ArEstimator estimator(
      {.method = method, .window = x.size(), .max_order = order, .remove_mean = false, .forgetting = forgetting});
  for (const Vec3& v : x) estimator.push(v);
  bool unstable = false;
  return estimator.fit(order, OrderRule::highest, unstable);
}

// Weighted least squares over t = order .. N - 1, dense: the axes are rows of their own.
Eigen::VectorXd dense_least_squares(const Signal& x, int order, double forgetting) {
  const auto n = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd A(3 * (n - order), order);
  Eigen::VectorXd b(3 * (n - order));
  for (Eigen::Index t = order; t < n; ++t) {
    const double root_weight = std::pow(forgetting, 0.5 * static_cast<double>(n - 1 - t));
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Index row = 3 * (t - order) + axis;
      b(row) = root_weight * x[static_cast<std::size_t>(t)][axis];
      for (int i = 0; i < order; ++i) A(row, i) = root_weight * x[static_cast<std::size_t>(t - 1 - i)][axis];
    }
  }
  return A.householderQr().solve(b);
}

void require_equal(const ArFit& fit, const Eigen::VectorXd& expected, double tolerance) {
  BOOST_REQUIRE(fit.order == expected.size());
  for (int i = 0; i < fit.order; ++i) {
    const double error = std::abs(fit.phi[static_cast<std::size_t>(i)] - expected(i));
    BOOST_TEST(error < tolerance, "phi_" << i + 1 << " is off by " << error);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(yule_walker_inverts_the_closed_form_of_a_second_order_process) {
  const double phi_1 = 1.2;
  const double phi_2 = -0.5;
  const double r_1 = phi_1 / (1 - phi_2);
  const std::vector<double> r{1, r_1, phi_1 * r_1 + phi_2};
  const ArFit model = fit_yule_walker(r, {.max_order = 2});
  BOOST_TEST(std::abs(model.phi[0] - phi_1) < 1e-7);
  BOOST_TEST(std::abs(model.phi[1] - phi_2) < 1e-7);
}

BOOST_AUTO_TEST_CASE(burg_of_three_samples_is_the_one_worked_by_hand) {
  // x = 1, 2, 4: k_1 = 2 (1 2 + 2 4) / (1 + 4 + 4 + 16) = 0.8. Then f = 4 - 1.6 = 2.4, b = 1 - 1.6 = -0.6, and
  // k_2 = 2 f b / (f^2 + b^2) = -2.88 / 6.12. phi_1 = k_1 - k_2 k_1, phi_2 = k_2.
  const Signal x{{1, 0, 0}, {2, 0, 0}, {4, 0, 0}};
  const Signal reversed(x.rbegin(), x.rend());
  std::vector<double> r(3);
  autocovariance(x, {}, r);
  const ArFit model = fit_burg(r, 3, x, reversed, {.max_order = 2});
  const double k_2 = -2.88 / 6.12;
  BOOST_REQUIRE(model.order == 2);
  BOOST_TEST(std::abs(model.phi[0] - 0.8 * (1 - k_2)) < 1e-7);
  BOOST_TEST(std::abs(model.phi[1] - k_2) < 1e-7);
  BOOST_TEST(std::abs(model.error_variance - 7 * (1 - 0.64) * (1 - k_2 * k_2)) < 1e-7);
}

BOOST_AUTO_TEST_CASE(burg_by_sums_is_burg_by_errors_as_numpy_computes_it) {
  const TemporaryFolder folder;
  const Signal x = auto_regressive({1.3, -0.9, 0.3}, 120, 3);
  const std::string samples = (folder.path() / "x.txt").string();
  const std::string script = (folder.path() / "burg.py").string();
  {
    std::ofstream out(samples);
    out.precision(17);
    for (const Vec3& v : x) out << v.x << ' ' << v.y << ' ' << v.z << '\n';
    std::ofstream(script) << R"(
import sys
import numpy as np
x = np.loadtxt(sys.argv[1])
f, b, a = x[1:].copy(), x[:-1].copy(), np.array([1.0])
for m in range(12):
    k = -2 * np.sum(f * b) / (np.sum(f * f) + np.sum(b * b))
    a = np.append(a, 0) + k * np.append(a, 0)[::-1]
    f, b = (f + k * b)[1:], (b + k * f)[:-1]
print(*(repr(float(-v)) for v in a[1:]))
)";
  }
  FILE* pipe = popen(("/usr/bin/python3 " + script + " " + samples).c_str(), "r");
  BOOST_REQUIRE(pipe != nullptr);
  Eigen::VectorXd expected(12);
  int read = 0;
  for (int i = 0; i < 12; ++i) read += std::fscanf(pipe, "%lf", &expected(i));
  BOOST_TEST(pclose(pipe) == 0);
  BOOST_REQUIRE(read == 12);
  require_equal(fit(ArMethod::burg, x, 12), expected, 1e-6);
}

BOOST_AUTO_TEST_CASE(burg_needs_few_samples_where_yule_walker_is_biased) {
  const std::vector<double> phi{1.9, -0.95};
  double burg = 0;
  double yule_walker = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Signal x = auto_regressive(phi, 40, 50 + seed);
    burg += std::abs(fit(ArMethod::burg, x, 2).phi[1] - phi[1]);
    yule_walker += std::abs(fit(ArMethod::yule_walker, x, 2).phi[1] - phi[1]);
  }
  BOOST_TEST(burg < 0.5 * yule_walker);
}

BOOST_AUTO_TEST_CASE(covariance_is_dense_least_squares) {
  for (const int order : {1, 2, 7, 20}) {
    const Signal x = auto_regressive({0.9, -0.4, 0.2}, 150, 8);
    require_equal(fit(ArMethod::covariance, x, order), dense_least_squares(x, order, 1), 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(covariance_finds_the_frequency_of_a_wave_without_noise) {
  Signal x;
  for (int t = 0; t < 60; ++t) x.push_back({std::exp(-0.01 * t) * std::sin(0.3 * t), 0, 0});
  const ArFit model = fit(ArMethod::covariance, x, 2);
  BOOST_TEST(std::abs(model.phi[0] - 2 * std::exp(-0.01) * std::cos(0.3)) < 1e-5);
  BOOST_TEST(std::abs(model.phi[1] + std::exp(-0.02)) < 1e-5);
}

BOOST_AUTO_TEST_CASE(recursion_is_the_least_squares_of_all_samples_by_their_weights) {
  const Signal x = auto_regressive({0.9, -0.4, 0.2}, 200, 9);
  require_equal(fit(ArMethod::rls, x, 6, 1.0), dense_least_squares(x, 6, 1.0), 1e-6);
  require_equal(fit(ArMethod::rls, x, 6, 0.97), dense_least_squares(x, 6, 0.97), 1e-6);
}

BOOST_AUTO_TEST_CASE(recursion_remembers_through_a_rest_what_least_squares_remembers) {
  const Signal moving = auto_regressive({0.9, -0.4, 0.2}, 120, 15);
  for (const int rest : {1, 3, 4, 30, 300}) {
    Signal x = moving;
    x.resize(moving.size() + static_cast<std::size_t>(rest));
    for (const Vec3& next : auto_regressive({0.9, -0.4, 0.2}, 12, 16)) {
      require_equal(fit(ArMethod::rls, x, 3, 0.97), dense_least_squares(x, 3, 0.97), 1e-5);
      x.push_back(next);
    }
  }
}

BOOST_AUTO_TEST_CASE(recursion_counts_the_samples_of_a_rest_and_forgets_as_it_does_while_something_moves) {
  RecursiveEquations sums(2, 0.9);
  const std::array<Vec3, 3> silent{};
  const std::array<Vec3, 3> moving{Vec3{2, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 0, 0}};
  for (int t = 0; t < 50; ++t) sums.add(silent);
  BOOST_TEST(std::abs(sums.samples() - 10 * (1 - std::pow(0.9, 50))) < 1e-9);
  sums.add(moving);
  for (int t = 0; t < 20; ++t) sums.add(silent);
  BOOST_TEST(std::abs(sums.equations().at(0, 0) / (4 * std::pow(0.9, 20)) - 1) < 1e-12);
  // In the end nothing is left, rather than what is too small to be divided by.
  for (int t = 0; t < 8000; ++t) sums.add(silent);
  BOOST_TEST(sums.equations().at(0, 0) == 0.0);
  BOOST_TEST(std::abs(sums.samples() - 10) < 1e-9);
}

BOOST_AUTO_TEST_CASE(recursion_starts_anew_where_rounding_of_a_blow_would_outweigh_what_comes) {
  const Signal x = auto_regressive({0.9, -0.4, 0.2}, 60, 17);
  Signal with_blow(20);
  with_blow[9] = {1e9, 0, 0};
  with_blow.insert(with_blow.end(), x.begin(), x.end());
  // Least squares from the first sample that is not zero again, with the rest before it as its regressors.
  const Signal anew(with_blow.begin() + 17, with_blow.end());
  require_equal(fit(ArMethod::rls, with_blow, 3, 0.99), dense_least_squares(anew, 3, 0.99), 1e-6);
}

BOOST_AUTO_TEST_CASE(every_order_of_one_factorisation_is_the_fit_of_that_order) {
  const Signal x = auto_regressive({1.2, -0.9, 0.5}, 300, 11);
  RecursiveEquations sums(10, 1.0);
  for (std::size_t t = 10; t < x.size(); ++t) {
    std::vector<Vec3> z;
    for (std::size_t i = 0; i <= 10; ++i) z.push_back(x[t - i]);
    sums.add(z);
  }
  const ArFit chosen = sums.equations().solve(1e-9, {.max_order = 10, .rule = OrderRule::bic, .samples = 290});
  BOOST_TEST(chosen.order == 3);
  const ArFit direct = sums.equations().solve(1e-9, {.max_order = 3, .samples = 290});
  for (std::size_t i = 0; i < 3; ++i) BOOST_TEST(std::abs(chosen.phi[i] - direct.phi[i]) < 1e-12);
  BOOST_TEST(std::abs(chosen.error_variance - 3) < 0.5);
}

BOOST_AUTO_TEST_CASE(a_regressor_without_energy_weighs_nothing) {
  NormalEquations sums(3);
  Dice draw(1);
  for (int t = 0; t < 50; ++t) {
    const Vec3 a = draw.normal_vector();
    const Vec3 b = draw.normal_vector();
    const std::array<Vec3, 4> z{2 * a - b, a, Vec3{}, b};
    sums.add(z, 1);
  }
  const ArFit model = sums.solve(1e-9, {.max_order = 3, .samples = 50});
  BOOST_TEST(std::abs(model.phi[0] - 2) < 1e-7);
  BOOST_TEST(model.phi[1] == 0.0);
  BOOST_TEST(std::abs(model.phi[2] + 1) < 1e-7);
}

BOOST_AUTO_TEST_CASE(criteria_are_as_published) {
  // Two models: the second halves nothing, 100 samples; AIC asks for ln(s1/s2) > 2/N, BIC for > ln(N)/N.
  const auto takes_second = [](OrderRule rule, double log_ratio) {
    OrderChoice choice({.max_order = 2, .rule = rule, .samples = 100});
    choice.better(1, 1.0);
    return choice.better(2, std::exp(-log_ratio));
  };
  BOOST_TEST(takes_second(OrderRule::aic, 0.0201));
  BOOST_TEST(!takes_second(OrderRule::aic, 0.0199));
  BOOST_TEST(takes_second(OrderRule::bic, std::log(100) / 100 + 1e-4));
  BOOST_TEST(!takes_second(OrderRule::bic, std::log(100) / 100 - 1e-4));
  BOOST_TEST(takes_second(OrderRule::fpe, std::log(103.0 / 97 / (102.0 / 98)) + 1e-6));
  BOOST_TEST(!takes_second(OrderRule::fpe, std::log(103.0 / 97 / (102.0 / 98)) - 1e-6));
}

BOOST_AUTO_TEST_CASE(stability_by_step_down_agrees_with_the_roots) {
  Dice draw(12);
  int stable = 0;
  constexpr int trials = 2000;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> phi(static_cast<std::size_t>(draw(1, 9)));
    for (double& p : phi) p = draw.normal(0.5);
    const double radius = spectral_radius(phi, 1);
    if (std::abs(radius - 1) < 1e-6) continue;
    BOOST_REQUIRE(is_stable(phi) == (radius < 1));
    stable += radius < 1;
  }
  BOOST_TEST(stable > trials / 10);
  BOOST_TEST(stable < trials * 9 / 10);
  BOOST_TEST(!is_stable(std::vector<double>{std::nan("")}));
}

BOOST_AUTO_TEST_CASE(every_fit_of_every_method_is_stable) {
  for (const ArMethod method : {ArMethod::yule_walker, ArMethod::burg, ArMethod::covariance, ArMethod::rls}) {
    for (int kind = 3; kind < hostile_kinds; ++kind) {
      if (kind == 5) continue;  // squares that overflow never reach an estimator
      for (const int order : {0, 1, 3, 20}) {
        Dice draw(static_cast<std::uint64_t>(kind));
        ArEstimator estimator(
            {.method = method, .window = 60, .max_order = 20, .remove_mean = false, .forgetting = 0.99});
        for (int t = 0; t < 200; ++t) {
          estimator.push(hostile(kind, t, draw).force);
          bool unstable = false;
          const ArFit model = estimator.fit(order, OrderRule::fpe, unstable);
          BOOST_REQUIRE_MESSAGE(is_stable(model.coefficients()), "method " << static_cast<int>(method) << ", kind "
                                                                           << kind << ", order " << order << ", step "
                                                                           << t);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(whittle_solves_the_block_toeplitz_system) {
  Dice draw(13);
  Eigen::Matrix3d Phi;
  Phi << 0.5, 0.3, 0, -0.2, 0.6, 0.1, 0, 0.2, 0.4;
  Signal x(400);
  for (std::size_t t = 1; t < x.size(); ++t) {
    const Eigen::Vector3d v = Phi * Eigen::Vector3d(x[t - 1].x, x[t - 1].y, x[t - 1].z);
    x[t] = Vec3{v.x(), v.y(), v.z()} + draw.normal_vector();
  }
  constexpr int order = 4;
  const VectorArFit model = fit_whittle(x, {}, {.max_order = order});
  BOOST_REQUIRE(model.order == order);
  std::vector<Eigen::Matrix3d> gamma(order + 1, Eigen::Matrix3d::Zero());
  for (std::size_t k = 0; k < gamma.size(); ++k) {
    for (std::size_t t = k; t < x.size(); ++t) {
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) gamma[k](i, j) += x[t][i] * x[t - k][j] / static_cast<double>(x.size());
      }
    }
  }
  // Gamma_k = sum_i Phi_i Gamma_{k-i}, k = 1 .. order, Gamma_{-k} = Gamma_k^T.
  Eigen::MatrixXd G(3 * order, 3 * order);
  Eigen::MatrixXd right(3, 3 * order);
  for (int k = 1; k <= order; ++k) {
    right.middleCols(3 * (k - 1), 3) = gamma[static_cast<std::size_t>(k)];
    for (int i = 1; i <= order; ++i) {
      const Eigen::Matrix3d& g = gamma[static_cast<std::size_t>(std::abs(k - i))];
      G.block(3 * (i - 1), 3 * (k - 1), 3, 3) = k >= i ? g : Eigen::Matrix3d(g.transpose());
    }
  }
  const Eigen::MatrixXd expected = G.transpose().partialPivLu().solve(right.transpose()).transpose();
  for (int i = 0; i < order; ++i) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        BOOST_TEST(std::abs(model.phi[static_cast<std::size_t>(9 * i + 3 * r + c)] - expected(r, 3 * i + c)) < 1e-7);
      }
    }
  }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) BOOST_TEST(std::abs(model.phi[static_cast<std::size_t>(3 * r + c)] - Phi(r, c)) < 0.2);
  }
}

BOOST_AUTO_TEST_CASE(whittle_is_stable_whatever_comes) {
  for (int kind = 3; kind < hostile_kinds; ++kind) {
    if (kind == 5) continue;
    Dice draw(static_cast<std::uint64_t>(kind));
    Signal x;
    for (int t = 0; t < 200; ++t) x.push_back(hostile(kind, t, draw).force);
    for (const OrderRule rule : {OrderRule::highest, OrderRule::fpe}) {
      const VectorArFit model = fit_whittle(x, {}, {.max_order = 8, .rule = rule, .samples = 200});
      const double radius = spectral_radius(std::span(model.phi).first(static_cast<std::size_t>(9 * model.order)), 3);
      BOOST_TEST(radius < 1 + 1e-9, "kind " << kind << ": " << radius);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_window_that_samples_have_left_by_age_is_the_shorter_window) {
  const Signal x = auto_regressive({0.9, -0.4}, 100, 14);
  for (const ArMethod method : {ArMethod::yule_walker, ArMethod::burg, ArMethod::covariance}) {
    ArEstimator estimator({.method = method, .window = 100, .max_order = 5});
    for (const Vec3& v : x) estimator.push(v);
    for (int i = 0; i < 40; ++i) estimator.drop_oldest();
    bool unstable = false;
    const ArFit shortened = estimator.fit(5, OrderRule::highest, unstable);
    const ArFit direct = fit(method, {x.begin() + 40, x.end()}, 5);
    for (std::size_t i = 0; i < 5; ++i) BOOST_TEST(std::abs(shortened.phi[i] - direct.phi[i]) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(gain_of_the_trend_filter_meets_the_riccati_equation) {
  // Steady state of constant velocity driven by white noise: position gain alpha, rate gain beta / T,
  // beta^2 / (1 - alpha) = q T^3 / r and alpha^2 = 2 beta - alpha beta - beta^2 / 6.
  for (const double departure : {0.001, 0.01, 0.1}) {
    constexpr double noise = 0.01;
    constexpr double T = 0.008;
    TrendFilter filter(Trend::constant_velocity, departure, noise, 1e6);
    for (int t = 0; t < 5000; ++t) filter.take(T, {});
    filter.take(T, {1, 0, 0});
    const double alpha = filter.ahead(0).x;
    const double beta = filter.ahead(T).x - alpha;
    const double q = 3 * departure * departure / std::pow(TrendFilter::departure_time, 3);
    BOOST_TEST(std::abs(beta * beta / (1 - alpha) / (q * T * T * T / (noise * noise)) - 1) < 1e-6);
    BOOST_TEST(std::abs((2 * beta - alpha * beta - beta * beta / 6) / (alpha * alpha) - 1) < 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(trend_filter_meets_a_parabola_on_uneven_times) {
  TrendFilter filter(Trend::constant_acceleration, 0.05, 0.005, 10);
  Dice draw(2);
  double t = 0;
  const auto x = [](double s) { return Vec3{1 + 2 * s - 3 * s * s, s * s, 4}; };
  for (int k = 0; k < 100; ++k) {
    const double interval = draw(0.005, 0.02);
    t += interval;
    filter.take(interval, x(t));
    if (k > 5) BOOST_REQUIRE(norm(filter.ahead(0.01) - x(t + 0.01)) < 1e-5);
  }
  BOOST_TEST(filter.restarts() == 0);
  filter.take(0.01, x(t) + Vec3{20, 0, 0});
  BOOST_TEST(filter.restarts() == 1);
}

BOOST_AUTO_TEST_CASE(grid_reads_a_line_at_even_times) {
  UniformGrid grid;
  Dice draw(5);
  double ms = 0;
  Stamped<Wrench> out;
  Time last{-1};
  for (int k = 0; k < 500; ++k) {
    ms += draw(5, 15);
    grid.push({stamp_ms(ms), {{1e-3 * ms, 2, 0}, {}}});
    while (grid.next(out)) {
      BOOST_REQUIRE(std::abs(out.value.force.x - out.stamp.valid.seconds()) < 1e-8);
      if (k > 100) BOOST_REQUIRE(std::abs((out.stamp.valid - last).seconds() - 0.01) < 0.002);
      last = out.stamp.valid;
    }
  }
  BOOST_TEST(std::abs(last.seconds() - ms * 1e-3) < 0.015);
  // After a pause it begins again at the sample behind it.
  grid.push({stamp_ms(ms + 5000), {{7, 0, 0}, {}}});
  BOOST_REQUIRE(grid.next(out));
  BOOST_TEST(out.value.force.x == 7.0);
  BOOST_TEST(!grid.next(out));
}

BOOST_AUTO_TEST_SUITE_END()
