// The velocity that is estimated from encoder positions: followed without lag, with the gains of its model.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <Eigen/Core>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>

#include "framework/realtime/motion_filter.hpp"

BOOST_AUTO_TEST_SUITE(motion_filter_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double departure = 2e-6, noise = 1e-5 / 3.4641016151377544;  // m
constexpr double period = 0.001;                                       // s
constexpr double calm_density = 20 * departure * departure / 1e-10;    // m^2/s^5

/// The filter's model, iterated as matrices with Joseph's form of the update, apart from the filter's code.
struct Riccati {
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gain;
  double q = calm_density;
  double variance = 0;  // of the innovation

  Riccati() { P(0, 0) = noise * noise; }
  static Eigen::Matrix3d transition(double T) {
    Eigen::Matrix3d F;
    F << 1, T, T * T / 2, 0, 1, T, 0, 0, 1;
    return F;
  }
  void step(double T) {
    const Eigen::Matrix3d F = transition(T);
    // The integral of F(s) e3 e3^T F(s)^T over the interval, by Gauss's rule of three points, exact up to degree 5.
    Eigen::Matrix3d Q = Eigen::Matrix3d::Zero();
    const double node[] = {-std::sqrt(0.6), 0, std::sqrt(0.6)}, weight[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d g = transition(T * (1 + node[i]) / 2).col(2);
      Q += T * weight[i] * g * g.transpose();
    }
    P = F * P * F.transpose() + q * Q;
    variance = P(0, 0) + noise * noise;
    gain = P.col(0) / variance;
    const Eigen::Matrix3d A = Eigen::Matrix3d::Identity() - gain * Eigen::RowVector3d(1, 0, 0);
    P = A * P * A.transpose() + noise * noise * gain * gain.transpose();
  }
};

/// Steps a filter through a sample one `interval` later.
void take(MotionFilter& filter, double interval, double x) {
  filter.take(interval, {x, 0, 0});
}
Vec3 take(MotionModel& model, double interval, double x) {
  model.predict(interval);
  return model.correct({x, 0, 0});
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_gains_are_those_of_the_riccati_equation_at_even_and_uneven_intervals) {
  MotionModel model(departure, noise);
  model.start({});
  Riccati riccati;
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int k = 1; k < 3000; ++k) {
    // Every seventh tick comes late, and once a second is missed altogether.
    const double T = k == 1500 ? 1 : k % 7 == 0 ? 2.5 * period : period;
    const double z = 1e-4 * std::sin(0.05 * k) + 2e-7 * (k * 37 % 11);
    riccati.step(T);
    x = Riccati::transition(T) * x;
    const double innovation = z - x(0);
    x += riccati.gain * innovation;
    const Vec3 likely = take(model, T, z);
    BOOST_REQUIRE_SMALL(model.value().x - x(0), 1e-12);
    BOOST_REQUIRE_SMALL(model.rate().x - x(1), 1e-9);
    BOOST_REQUIRE(model.rate().y == 0.0);
    const double square = std::clamp(innovation * innovation / riccati.variance, 3.0, 36.0);
    BOOST_REQUIRE_SMALL(likely.x + 0.5 * (square + std::log(riccati.variance / (noise * noise))), 1e-6);
    BOOST_REQUIRE_SMALL(likely.y + 0.5 * (3 + std::log(riccati.variance / (noise * noise))), 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(a_model_that_knows_nothing_takes_the_sample_and_has_no_merit_of_it_on_any_axis) {
  MotionModel model(departure, noise);
  const Vec3 sample{1, -2, 3};
  const Vec3 likely = model.correct(sample);
  // That of six standard deviations: the least that there is.
  for (int axis = 0; axis < 3; ++axis) BOOST_TEST(likely[axis] == -0.5 * 36);
  BOOST_TEST(norm(model.value() - sample) == 0);
  BOOST_TEST(norm(model.rate()) == 0);
}

BOOST_AUTO_TEST_CASE(one_model_that_adapts_takes_more_process_noise_while_the_motion_surprises_it) {
  for (const double amplitude : {1e-5, 1e-3}) {
    MotionFilter filter(departure, noise, true);
    filter.start({});
    Riccati model;
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    double mean = 0, most = 1;
    for (int k = 1; k < 3000; ++k) {
      const double T = k == 1500 ? 1 : k % 7 == 0 ? 2.5 * period : period;
      const double z = amplitude * std::sin(0.05 * k) + 2e-7 * (k * 37 % 11);
      const double increase = std::clamp(mean * mean / 16, 1.0, 100.0);
      most = std::max(most, increase);
      model.q = increase * calm_density;
      model.step(T);
      x = Riccati::transition(T) * x;
      const double innovation = z - x(0), kept = std::exp(-T / 0.02);
      x += model.gain * innovation;
      mean = kept * mean + (1 - kept) * std::min(innovation * innovation / model.variance, 100.0);
      take(filter, T, z);
      BOOST_REQUIRE_SMALL(filter.value().x - x(0), 1e-11);
      BOOST_REQUIRE_SMALL(filter.rate().x - x(1), 1e-8);
    }
    if (amplitude < 1e-4) BOOST_TEST(most == 1.0);
    if (amplitude > 1e-4) BOOST_TEST(most > 10);
  }
}

BOOST_AUTO_TEST_CASE(the_rate_is_the_mean_over_the_models_by_how_likely_the_last_tenth_of_a_second_was) {
  MotionFilter filter(departure, noise);
  filter.start({});
  std::vector<MotionModel> models;
  for (const std::size_t order : {3, 4}) {
    for (int i = 0; i < 6; ++i)
      models.emplace_back((order == 3 ? 1 : 0.25) * departure * std::pow(4.0, i - 1), noise, order);
  }
  for (MotionModel& model : models) model.start({});
  std::vector<Vec3> logarithm(models.size());
  for (int k = 1; k < 2000; ++k) {
    // At rest, then a tremor of 30 Hz along x; y stays at rest.
    const Vec3 z{(k < 800 ? 1e-6 : 2e-4) * std::sin(2 * 3.14159265 * 30 * k * period) + 1e-6 * (k * 37 % 11), 1e-6, 0};
    Vec3 most{-1e300, -1e300, -1e300}, sum, rate;
    for (std::size_t i = 0; i < models.size(); ++i) {
      models[i].predict(period);
      logarithm[i] = std::exp(-0.01) * logarithm[i] + models[i].correct(z);
      for (int axis = 0; axis < 3; ++axis) most[axis] = std::max(most[axis], logarithm[i][axis]);
    }
    for (std::size_t i = 0; i < models.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        const double weight = std::exp(logarithm[i][axis] - most[axis]);
        sum[axis] += weight;
        rate[axis] += weight * models[i].rate()[axis];
      }
    }
    filter.take(period, z);
    for (int axis = 0; axis < 3; ++axis) {
      const double expected = rate[axis] / sum[axis];
      BOOST_REQUIRE_SMALL(filter.rate()[axis] - expected, 1e-8 + 1e-6 * std::abs(expected));
    }
    const auto& w = filter.weights();
    const auto calm = [&w](int axis) { return w[0][axis] + w[1][axis] + w[6][axis] + w[7][axis]; };
    if (k == 799) BOOST_TEST(calm(0) > 0.9);
    if (k == 1999) BOOST_TEST(calm(0) < 0.1);
    if (k == 1999) BOOST_TEST(calm(1) > 0.9);
  }
}

BOOST_AUTO_TEST_CASE(estimates_stay_finite_and_near_whatever_the_intervals) {
  boost::random::mt19937_64 engine(11);
  boost::random::normal_distribution<double> normal(0, 1);
  for (const double step : {1e-7, 1e-5, 1e-3}) {
    MotionFilter filter(departure, step);
    filter.start({});
    double t = 0;
    for (int k = 0; k < 100'000; ++k) {
      const double T = period * std::exp(normal(engine) * (k % 1000 == 0 ? 3 : 0.5));
      t += T;
      const double z = 0.01 * std::sin(20 * t) + step * normal(engine);
      take(filter, T, z);
      BOOST_REQUIRE(std::abs(filter.value().x - z) < 0.1);
      BOOST_REQUIRE(std::abs(filter.rate().x) < 20);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_model_of_order_4_follows_a_constant_jerk_and_has_the_gains_of_its_riccati_equation) {
  MotionModel model(departure, noise, 4);
  model.start({});
  Eigen::Matrix4d F = Eigen::Matrix4d::Identity(), Q = Eigen::Matrix4d::Zero(), P = Eigen::Matrix4d::Zero();
  const double T = period, T10 = 0.01;
  const Eigen::Vector4d into{T * T * T / 6, T * T / 2, T, 1};
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) F(i, j) = into(3 - (j - i));
  }
  // The integral of F(s) e4 e4^T F(s)^T by Simpson's rule over many steps, and the q that makes the departure in 10 ms.
  const auto integral = [](double until) {
    constexpr int n = 200;
    Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
    for (int k = 0; k <= n; ++k) {
      const double s = until * k / n;
      const Eigen::Vector4d g{s * s * s / 6, s * s / 2, s, 1};
      sum += (k == 0 || k == n ? 1 : k % 2 == 1 ? 4 : 2) * g * g.transpose();
    }
    return Eigen::Matrix4d(until / n / 3 * sum);
  };
  Q = departure * departure / integral(T10)(0, 0) * integral(T);
  P(0, 0) = noise * noise;
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  for (int k = 1; k < 3000; ++k) {
    const double t = k * T, z = 0.4 * t * t * t;  // jerk of 2.4 m/s^3
    P = F * P * F.transpose() + Q;
    x = F * x;
    const Eigen::Vector4d gain = P.col(0) / (P(0, 0) + noise * noise);
    x += gain * (z - x(0));
    P = (P - gain * P.row(0)).eval();
    take(model, T, z);
    BOOST_REQUIRE_SMALL(model.value().x - x(0), 1e-10 * (1 + std::abs(x(0))));
    BOOST_REQUIRE_SMALL(model.rate().x - x(1), 1e-7 * (1 + std::abs(x(1))));
    if (t > 1) BOOST_REQUIRE_SMALL(model.rate().x - 1.2 * t * t, 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(a_damper_on_the_rate_damps_a_shaken_handle_which_the_calm_model_would_drive) {
  // The steady filter in continuous time, w = (q / (R T))^(1/6): v^ / v = (2 w^2 s + w^3) / (s^3 + 2 w s^2 + 2 w^2 s +
  // w^3).
  const double w = std::pow(calm_density / (noise * noise * period), 1.0 / 6), shaken = 2 * w;
  const std::complex<double> s(0, shaken);
  const std::complex<double> calm =
      (2 * w * w * s + w * w * w) / (s * s * s + 2 * w * s * s + 2 * w * w * s + w * w * w);
  BOOST_TEST(calm.real() < 0.0);  // more than a quarter of a period late
  const auto response = [&](auto filter, double amplitude) {
    filter.start({});
    std::complex<double> sum;
    constexpr int settling = 1000, count = 20'000;
    for (int k = 1; k <= settling + count; ++k) {
      take(filter, period, amplitude * std::sin(shaken * k * period));
      if (k > settling) sum += filter.rate().x * std::polar(1.0, -shaken * k * period);
    }
    return 2.0 / (count * amplitude * shaken) * sum;
  };
  // Samples are half a period late in the mean, 0.21 rad here.
  BOOST_TEST(std::abs(response(MotionModel(departure, noise), 1e-6) - calm) < 0.25 * std::abs(calm));
  for (const double amplitude : {2e-5, 1e-4, 1e-3}) {
    BOOST_TEST(response(MotionFilter(departure, noise), amplitude).real() > 0.0);
  }
}

BOOST_AUTO_TEST_CASE(a_wild_sample_makes_no_more_velocity_than_with_the_calm_model) {
  for (const double jump : {1e-4, 1e-3, 1e-2}) {
    MotionFilter filter(departure, noise);
    filter.start({});
    Riccati model;
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    double most = 0, calm_most = 0, sum = 0, calm_sum = 0;
    for (int k = 1; k < 1200; ++k) {
      const double z = k == 1000 ? jump : 0.0;
      model.step(period);
      x = Riccati::transition(period) * x;
      x += model.gain * (z - x(0));
      take(filter, period, z);
      most = std::max(most, std::abs(filter.rate().x));
      calm_most = std::max(calm_most, std::abs(x(1)));
      sum += filter.rate().x * filter.rate().x;
      calm_sum += x(1) * x(1);
    }
    BOOST_TEST(most <= calm_most * (1 + 1e-9));
    BOOST_TEST(sum <= 1.1 * calm_sum);
  }
}

BOOST_AUTO_TEST_CASE(white_noise_makes_the_variance_of_the_rate_that_its_gains_tell) {
  // e' = (1 - K H) F e - K n in the steady state, so S = A S A^T + R K K^T, whatever the process noise.
  Riccati model;
  for (int k = 0; k < 5000; ++k) model.step(period);
  const Eigen::Matrix3d A =
      (Eigen::Matrix3d::Identity() - model.gain * Eigen::RowVector3d(1, 0, 0)) * Riccati::transition(period);
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 5000; ++k) {
    S = (A * S * A.transpose() + noise * noise * model.gain * model.gain.transpose()).eval();
  }
  MotionModel filter(departure, noise);
  filter.start({});
  boost::random::mt19937_64 engine(7);
  boost::random::normal_distribution<double> normal(0, noise);
  double sum = 0;
  constexpr int settling = 1000, count = 400'000;
  for (int k = 0; k < settling + count; ++k) {
    filter.predict(period);
    filter.correct(Vec3{normal(engine), normal(engine), normal(engine)});
    if (k >= settling) sum += dot(filter.rate(), filter.rate()) / 3;
  }
  // 1.2 million samples, correlated over some 20 ms: 60,000 free ones, a standard error below 0.6 %.
  BOOST_TEST(sum / count == S(1, 1), tt::tolerance(0.03));
  // The filter believes in more: its covariance counts the motion too.
  BOOST_TEST(S(1, 1) < model.P(1, 1));
}

BOOST_AUTO_TEST_SUITE_END()
