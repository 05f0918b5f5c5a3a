// The lattice against the recursion that it stands for, and its variance against sums of their own.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <vector>

#include "nodes/effect/lattice.hpp"
#include "nodes/prediction/autoregression.hpp"
#include "tests/support/force_stream.hpp"

BOOST_AUTO_TEST_SUITE(lattice_test)

using namespace tactor;
using namespace tactor::test;

namespace {

const std::vector<std::vector<double>> filters{{0.9}, {1.6, -0.8}, {0.5, -0.3, 0.2, 0.1, -0.4}, {1.8, -1.5, 0.9, -0.3}};

/// The coefficients that reflections stand for, by stepping up.
std::vector<double> coefficients(const Reflection& reflection, std::size_t order) {
  ArFit fit;
  for (std::size_t m = 0; m < order; ++m) {
    step_up(fit, reflection.k[m]);
  }
  return {fit.phi.begin(), fit.phi.begin() + static_cast<std::ptrdiff_t>(order)};
}

}  // namespace

BOOST_AUTO_TEST_CASE(reflections_are_those_of_the_coefficients) {
  for (const auto& phi : filters) {
    const auto reflection = Reflection::of(phi);
    BOOST_REQUIRE(reflection.has_value());
    const std::vector<double> back = coefficients(*reflection, phi.size());
    for (std::size_t i = 0; i < phi.size(); ++i) BOOST_TEST(std::abs(back[i] - phi[i]) < 1e-12);
  }
  BOOST_TEST(!Reflection::of(std::vector<double>{1.0}).has_value());
  BOOST_TEST(!Reflection::of(std::vector<double>{2.1, -1.2}).has_value());
  BOOST_TEST(!Reflection::of(std::vector<double>{0.5, std::nan("")}).has_value());
  BOOST_TEST(!Reflection::of(std::vector<double>(33, 0.0)).has_value());
}

BOOST_AUTO_TEST_CASE(the_lattice_is_the_recursion) {
  for (const auto& phi : filters) {
    const Reflection reflection = *Reflection::of(phi);
    const double deviation = std::sqrt(reflection.gain());  // of x where e has 1
    NormalisedLattice lattice;
    Dice draw(3);
    std::vector<double> x;
    for (std::size_t t = 0; t < 500; ++t) {
      const double e = draw.normal();
      double next = e;
      for (std::size_t i = 0; i < phi.size() && i < t; ++i) next += phi[i] * x[t - 1 - i];
      x.push_back(next);
      BOOST_TEST(std::abs(deviation * lattice.next(reflection, e) - next) < 1e-9);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_gain_is_the_sum_of_the_squared_impulse_response) {
  for (const auto& phi : filters) {
    std::vector<double> response{1};
    double sum = 1;
    for (std::size_t t = 1; t < 5000; ++t) {
      double next = 0;
      for (std::size_t i = 0; i < phi.size() && i < t; ++i) next += phi[i] * response[t - 1 - i];
      response.push_back(next);
      sum += next * next;
    }
    BOOST_TEST(std::abs(Reflection::of(phi)->gain() - sum) < 1e-9 * sum);
  }
}

BOOST_AUTO_TEST_CASE(however_the_coefficients_change_the_signal_has_the_variance_of_the_noise) {
  NormalisedLattice lattice;
  Dice draw(5);
  double energy = 0, noise = 0, largest = 0;
  constexpr int samples = 200000;
  for (int t = 0; t < samples; ++t) {
    Reflection wild;
    for (double& k : wild.k) k = draw(-0.999, 0.999);
    const double e = draw.normal(), x = lattice.next(wild, e);
    energy += x * x;
    noise += e * e;
    largest = std::max(largest, std::abs(x));
  }
  BOOST_TEST(std::abs(energy / noise - 1) < 0.03);
  BOOST_TEST(largest < 10.0);
}

BOOST_AUTO_TEST_SUITE_END()
