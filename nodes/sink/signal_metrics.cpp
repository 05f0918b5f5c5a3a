#include "nodes/sink/signal_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

double root_mean(double sum, std::size_t count) {
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

std::vector<Vec3> without_mean(std::span<const Vec3> x) {
  Vec3 sum;
  for (const Vec3& v : x) sum += v;
  const Vec3 mean = sum / static_cast<double>(x.size());
  std::vector<Vec3> result(x.begin(), x.end());
  for (Vec3& v : result) v -= mean;
  return result;
}

}  // namespace

double rms(std::span<const double> x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return root_mean(sum, x.size());
}

double rms(std::span<const Vec3> x) {
  double sum = 0;
  for (const Vec3& v : x) sum += dot(v, v);
  return root_mean(sum, x.size());
}

double rms_error(std::span<const Vec3> x, std::span<const Vec3> reference) {
  TACTOR_DEMAND(x.size() == reference.size());
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += dot(x[i] - reference[i], x[i] - reference[i]);
  return root_mean(sum, x.size());
}

double max_error(std::span<const Vec3> x, std::span<const Vec3> reference) {
  TACTOR_DEMAND(x.size() == reference.size());
  double largest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) largest = std::max(largest, norm(x[i] - reference[i]));
  return largest;
}

Smoothness smoothness(std::span<const Vec3> x, double step_ms) {
  Smoothness result;
  if (x.size() < 2) return result;
  double sum1 = 0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const Vec3 d = x[i] - x[i - 1];
    sum1 += dot(d, d);
    result.max_step = std::max(result.max_step, norm(d));
  }
  double sum2 = 0;
  for (std::size_t i = 2; i < x.size(); ++i) {
    const Vec3 d = x[i] - 2.0 * x[i - 1] + x[i - 2];
    sum2 += dot(d, d);
  }
  result.rms_d1 = root_mean(sum1, x.size() - 1) / step_ms;
  result.rms_d2 = root_mean(sum2, x.size() - 2) / (step_ms * step_ms);
  return result;
}

std::optional<double> delay_steps(std::span<const Vec3> x, std::span<const Vec3> reference, std::int64_t max_lag) {
  TACTOR_DEMAND(x.size() == reference.size() && max_lag >= 0);
  const auto n = static_cast<std::int64_t>(x.size());
  if (n <= 2 * max_lag || n == 0) return std::nullopt;
  const std::vector<Vec3> a = without_mean(x);
  const std::vector<Vec3> b = without_mean(reference);
  const auto correlation = [&](std::int64_t lag) {
    double ab = 0;
    double aa = 0;
    double bb = 0;
    Vec3 sum_a;
    Vec3 sum_b;
    for (std::int64_t i = std::max<std::int64_t>(0, -lag); i < std::min(n, n - lag); ++i) {
      const Vec3& p = a[static_cast<std::size_t>(i + lag)];
      const Vec3& q = b[static_cast<std::size_t>(i)];
      ab += dot(p, q);
      aa += dot(p, p);
      bb += dot(q, q);
      sum_a += p;
      sum_b += q;
    }
    const double count = static_cast<double>(n - std::abs(lag));
    ab -= dot(sum_a, sum_b) / count;
    aa -= dot(sum_a, sum_a) / count;
    bb -= dot(sum_b, sum_b) / count;
    // Rounding of the mean leaves a constant signal with next to no energy; the test below sees the whole signal.
    return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
  };
  constexpr double nothing = 1e-12;
  if (!(rms(a) > nothing * rms(x)) || !(rms(b) > nothing * rms(reference))) return std::nullopt;
  std::vector<double> c(static_cast<std::size_t>(2 * max_lag + 1));
  for (std::int64_t lag = -max_lag; lag <= max_lag; ++lag)
    c[static_cast<std::size_t>(lag + max_lag)] = correlation(lag);
  std::int64_t best = 0;
  const auto at = [&](std::int64_t lag) { return c[static_cast<std::size_t>(lag + max_lag)]; };
  for (std::int64_t size = 1; size <= max_lag; ++size) {
    for (const std::int64_t lag : {size, -size}) {
      if (at(lag) > at(best)) best = lag;
    }
  }
  if (std::abs(best) == max_lag) return static_cast<double>(best);
  const double bend = at(best - 1) - 2.0 * at(best) + at(best + 1);
  const double shift = bend < 0 ? 0.5 * (at(best - 1) - at(best + 1)) / bend : 0.0;
  return static_cast<double>(best) + shift;
}

double share_beyond(std::span<const Vec3> x, std::span<const Vec3> reference, double floor, double fraction) {
  TACTOR_DEMAND(x.size() == reference.size());
  if (x.empty()) return 0;
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (norm(x[i] - reference[i]) > std::max(floor, fraction * norm(reference[i]))) ++beyond;
  }
  return static_cast<double>(beyond) / static_cast<double>(x.size());
}

AfterLoss after_loss(std::span<const Vec3> x, std::span<const Vec3> reference, double threshold, std::int64_t window) {
  TACTOR_DEMAND(x.size() == reference.size());
  AfterLoss result;
  const auto length = static_cast<std::size_t>(window);
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double before = norm(reference[i - 1]);
    if (before <= threshold || norm(reference[i]) > threshold) continue;
    const Vec3 direction = reference[i - 1] / before;
    const std::size_t end = std::min(x.size(), i + length);
    for (std::size_t j = i; j < end && norm(reference[j]) <= threshold; ++j) {
      const double left_over = dot(x[j] - reference[j], direction);
      result.overshoot = std::max(result.overshoot, -left_over);
      if (j >= i + length / 2) result.ghost = std::max(result.ghost, left_over);
    }
  }
  return result;
}

}  // namespace tactor
