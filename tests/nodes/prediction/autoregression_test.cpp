// The fit against known processes, against Eigen's dense solution and against the sums written out.
#include "nodes/prediction/autoregression.hpp"

#include <Eigen/Cholesky>
#include <boost/test/unit_test.hpp>
#include <vector>

#include "nodes/prediction/sample_window.hpp"
#include "tests/support/force_stream.hpp"

BOOST_AUTO_TEST_SUITE(autoregression_test)

using namespace tactor;
using namespace tactor::test;

namespace {

using Signal = std::vector<Vec3>;

std::vector<double> lags_of(const Signal& x, int order) {
  std::vector<double> r(static_cast<std::size_t>(order) + 1);
  autocovariance(x, {}, r);
  return r;
}

// Signals that fits are known to fail on.
Signal adversarial(int kind, std::size_t n, Dice& draw) {
  Signal x(n);
  for (std::size_t t = 0; t < n; ++t) {
    const double s = static_cast<double>(t);
    switch (kind) {
      case 0:
        x[t] = draw.normal_vector();
        break;
      case 1:
        x[t] = {std::sin(0.3 * s), std::cos(0.3 * s), 0};
        break;
      case 2:
        x[t] = {5, -3, 1};
        break;
      case 3:
        x[t] = t == n / 2 ? Vec3{20, 0, 0} : Vec3{};
        break;
      case 4:
        x[t] = {0.01 * s, 0, 0};
        break;
      case 5:
        x[t] = {t % 2 == 0 ? 1.0 : -1.0, 0, 0};
        break;
      case 6:
        x[t] = {std::exp(0.05 * s), 0, 0};
        break;
      default:
        x[t] = {std::min(8.0, 20 * std::abs(std::sin(0.05 * s))), 0, 0};
        break;
    }
  }
  return x;
}
constexpr int adversarial_kinds = 8;

}  // namespace

BOOST_AUTO_TEST_CASE(autocovariance_is_the_sum_of_scalar_products_over_a_common_divisor) {
  const Signal x{{1, 0, 2}, {0, 3, 1}, {-1, 1, 0}};
  std::vector<double> r(5);
  autocovariance(x, {}, r);
  BOOST_TEST(r[0] == (5.0 + 10.0 + 2.0) / 3);
  BOOST_TEST(r[1] == (2.0 + 3.0) / 3);
  BOOST_TEST(r[2] == -1.0 / 3);
  BOOST_TEST(r[3] == 0.0);
  BOOST_TEST(r[4] == 0.0);
}

BOOST_AUTO_TEST_CASE(levinson_solves_the_toeplitz_system) {
  for (int order = 1; order <= 20; ++order) {
    const std::vector<double> r =
        lags_of(auto_regressive({0.6, -0.2, 0.1}, 300, 10U + static_cast<unsigned>(order)), order);
    const ArFit fit = fit_yule_walker(r, {.max_order = order});
    Eigen::MatrixXd R(order, order);
    Eigen::VectorXd b(order);
    for (int i = 0; i < order; ++i) {
      for (int j = 0; j < order; ++j) R(i, j) = r[static_cast<std::size_t>(std::abs(i - j))];
      R(i, i) *= 1 + 1e-9;
      b(i) = r[static_cast<std::size_t>(i) + 1];
    }
    const Eigen::VectorXd expected = R.ldlt().solve(b);
    BOOST_REQUIRE(fit.order == order);
    for (int i = 0; i < order; ++i) BOOST_TEST(std::abs(fit.phi[static_cast<std::size_t>(i)] - expected(i)) < 1e-11);
    BOOST_TEST(std::abs(fit.error_variance - (r[0] * (1 + 1e-9) - b.dot(expected))) < 1e-11 * r[0]);
  }
}

BOOST_AUTO_TEST_CASE(coefficients_of_a_known_process_are_recovered) {
  const std::vector<double> phi{1.2, -0.6, 0.2};
  const ArFit fit = fit_yule_walker(lags_of(auto_regressive(phi, 100000, 3), 3), {.max_order = 3});
  // The standard error of a coefficient is about sqrt(1 / (3 N)) = 0.0018.
  for (std::size_t i = 0; i < 3; ++i) BOOST_TEST(std::abs(fit.phi[i] - phi[i]) < 0.01);
  BOOST_TEST(std::abs(fit.error_variance - 3.0) < 0.05);
}

BOOST_AUTO_TEST_CASE(coefficients_do_not_depend_on_the_frame_or_the_unit) {
  const Signal x = auto_regressive({0.9, -0.3}, 300, 5);
  const ArFit fit = fit_yule_walker(lags_of(x, 10), {.max_order = 10});
  Dice draw(6);
  for (const double unit : {1e-6, 1.0, 1e6}) {
    const Quat R = from_rotation_vector(draw.normal_vector());
    Signal turned = x;
    for (Vec3& v : turned) v = unit * rotate(R, v);
    const ArFit other = fit_yule_walker(lags_of(turned, 10), {.max_order = 10});
    BOOST_REQUIRE(other.order == fit.order);
    for (std::size_t i = 0; i < 10; ++i) BOOST_TEST(std::abs(other.phi[i] - fit.phi[i]) < 1e-11);
  }
}

BOOST_AUTO_TEST_CASE(final_prediction_error_finds_the_order_most_of_the_time) {
  int right = 0;
  int too_low = 0;
  constexpr int runs = 200;
  for (int run = 0; run < runs; ++run) {
    const Signal x = auto_regressive({1.2, -0.9, 0.5}, 300, 1000U + static_cast<unsigned>(run));
    const ArFit fit = fit_yule_walker(lags_of(x, 10), {.max_order = 10, .rule = OrderRule::fpe, .samples = 300});
    right += fit.order == 3;
    too_low += fit.order < 3;
  }
  BOOST_TEST(right > runs / 2);
  BOOST_TEST(too_low == 0);
}

BOOST_AUTO_TEST_CASE(final_prediction_error_is_akaikes) {
  BOOST_TEST(final_prediction_error(2.0, 3, 100) == 2.0 * 104 / 96);
}

BOOST_AUTO_TEST_CASE(roots_of_every_fit_are_inside_the_unit_circle) {
  Dice draw(9);
  for (int kind = 0; kind < adversarial_kinds; ++kind) {
    for (int order = 1; order <= 20; ++order) {
      const std::vector<double> r = lags_of(adversarial(kind, 300, draw), order);
      for (const bool by_fpe : {false, true}) {
        const ArFit fit = fit_yule_walker(
            r, {.max_order = order, .rule = by_fpe ? OrderRule::fpe : OrderRule::highest, .samples = 300});
        BOOST_TEST(spectral_radius(fit.coefficients(), 1) < 1.0, "kind " << kind << ", order " << order);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(nothing_is_fitted_to_no_energy) {
  BOOST_TEST(!has_energy(0.0, 0.0));
  BOOST_TEST(!has_energy(4.9e-324, 0.0));
  BOOST_TEST(!has_energy(std::nan(""), 0.0));
  BOOST_TEST(!has_energy(std::numeric_limits<double>::infinity(), 0.0));
  BOOST_TEST(has_energy(1e-12, 0.0));
  BOOST_TEST(!has_energy(1e-12, 1e-11));
}

BOOST_AUTO_TEST_CASE(sliding_autocovariance_is_the_one_from_scratch) {
  Dice draw(11);
  AutocovarianceWindow window(60, 8, false);
  Signal all;
  std::vector<double> r(8);
  std::vector<double> expected(8);
  for (int t = 0; t < 5000; ++t) {
    // Bursts of huge samples test that nothing of them is left once they are gone.
    const double size = t % 700 == 5 ? 1e9 : t % 900 < 100 ? 1e-3 : 1.0;
    all.push_back(draw.normal_vector(size));
    window.push(all.back());
    if (!window.full()) continue;
    window.covariances(r);
    autocovariance(std::span(all).last(60), {}, expected);
    for (std::size_t k = 0; k < 8; ++k) BOOST_REQUIRE(std::abs(r[k] - expected[k]) <= 1e-9 * expected[0]);
  }
}

BOOST_AUTO_TEST_CASE(a_constant_has_no_energy_about_its_mean) {
  AutocovarianceWindow window(300, 3, true);
  for (int t = 0; t < 300; ++t) window.push({0.1, -1.0 / 3, 7.7});
  std::vector<double> r(3);
  window.covariances(r);
  BOOST_TEST(!has_energy(r[0], window.noise()));
}

BOOST_AUTO_TEST_SUITE_END()
