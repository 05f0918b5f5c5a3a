#include "framework/core/signal_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

double root_mean(double sum, std::size_t count) {
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

/// One pair of poles of a Butterworth high-pass by the bilinear transform, in transposed direct form II, from rest.
class HighPassPair {
 public:
  /// `warped` is tan(pi cutoff / rate), `quality` the Q of the pair.
  HighPassPair(double warped, double quality) {
    const double scale = 1.0 / (1.0 + warped / quality + warped * warped);
    b0_ = scale;
    a1_ = 2.0 * (warped * warped - 1.0) * scale;
    a2_ = (1.0 - warped / quality + warped * warped) * scale;
  }
  void run(std::vector<Vec3>& x) const {
    Vec3 s1;
    Vec3 s2;
    for (Vec3& v : x) {
      const Vec3 in = b0_ * v;
      const Vec3 out = in + s1;
      s1 = s2 - 2.0 * in - a1_ * out;
      s2 = in - a2_ * out;
      v = out;
    }
  }

 private:
  double b0_, a1_, a2_;
};

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

double rms_above(std::span<const Vec3> x, double cutoff_hz, double rate_hz) {
  TACTOR_DEMAND(cutoff_hz > 0 && rate_hz > 2 * cutoff_hz);
  if (x.size() < 2) return 0;
  const std::size_t pad = std::min(x.size() - 1, static_cast<std::size_t>(std::ceil(3 * rate_hz / cutoff_hz)));
  std::vector<Vec3> y;
  y.reserve(x.size() + 2 * pad);
  for (std::size_t i = pad; i > 0; --i) y.push_back(2.0 * x.front() - x[i]);
  y.insert(y.end(), x.begin(), x.end());
  for (std::size_t i = 1; i <= pad; ++i) y.push_back(2.0 * x.back() - x[x.size() - 1 - i]);
  const double warped = std::tan(std::numbers::pi * cutoff_hz / rate_hz);
  for (int way = 0; way < 2; ++way) {
    // A constant does not pass, so taking the first value away starts the filter at rest.
    const Vec3 first = y.front();
    for (Vec3& v : y) v -= first;
    // The poles of fourth order lie at pi/8 and 3 pi/8 from the real axis.
    for (const double angle : {std::numbers::pi / 8, 3 * std::numbers::pi / 8}) {
      HighPassPair(warped, 0.5 / std::cos(angle)).run(y);
    }
    std::reverse(y.begin(), y.end());
  }
  return rms(std::span<const Vec3>(y).subspan(pad, x.size()));
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
  constexpr double as_high = 0.98;  // of the highest, and a peak counts as one as high
  if (!(rms(a) > nothing * rms(x)) || !(rms(b) > nothing * rms(reference))) return std::nullopt;
  std::vector<double> c(static_cast<std::size_t>(2 * max_lag + 1));
  for (std::int64_t lag = -max_lag; lag <= max_lag; ++lag)
    c[static_cast<std::size_t>(lag + max_lag)] = correlation(lag);
  const auto at = [&](std::int64_t lag) { return c[static_cast<std::size_t>(lag + max_lag)]; };
  const double enough = as_high * *std::max_element(c.begin(), c.end());
  const auto is_peak = [&](std::int64_t lag) {
    return std::abs(lag) < max_lag && at(lag) >= enough && at(lag) >= at(lag - 1) && at(lag) >= at(lag + 1);
  };
  for (std::int64_t size = 0; size < max_lag; ++size) {
    // Of two as near to zero the higher.
    const std::int64_t best = is_peak(size) && !(is_peak(-size) && at(-size) > at(size)) ? size : -size;
    if (!is_peak(best)) continue;
    const double bend = at(best - 1) - 2.0 * at(best) + at(best + 1);
    const double shift = bend < 0 ? 0.5 * (at(best - 1) - at(best + 1)) / bend : 0.0;
    return static_cast<double>(best) + shift;
  }
  return std::nullopt;
}

namespace {

std::vector<Vec3> changes(std::span<const Vec3> x, std::int64_t steps) {
  std::vector<Vec3> out;
  for (auto i = static_cast<std::size_t>(steps); i < x.size(); ++i) {
    out.push_back(x[i] - x[i - static_cast<std::size_t>(steps)]);
  }
  return out;
}

}  // namespace

std::optional<double> delay_of_changes(std::span<const Vec3> x, std::span<const Vec3> reference, std::int64_t max_lag,
                                       std::int64_t change) {
  TACTOR_DEMAND(x.size() == reference.size() && change > 0);
  return delay_steps(changes(x, change), changes(reference, change), max_lag);
}

bool is_explained_by(double late, std::span<const Vec3> x, std::span<const Vec3> reference) {
  TACTOR_DEMAND(x.size() == reference.size());
  constexpr double most_unexplained = 0.5;
  const auto count = static_cast<double>(reference.size());
  double varies = 0, differs = 0, compared = 0;
  for (const Vec3& force : without_mean(reference)) varies += dot(force, force) / count;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double at = static_cast<double>(i) - late;
    if (at < 0 || at > count - 1) continue;
    const auto before = static_cast<std::size_t>(at);
    const Vec3& first = reference[before];
    const Vec3& second = reference[std::min(before + 1, reference.size() - 1)];
    const Vec3 then = first + (at - static_cast<double>(before)) * (second - first);
    differs += dot(x[i] - then, x[i] - then);
    ++compared;
  }
  return compared > 0 && differs / compared < most_unexplained * most_unexplained * varies;
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

std::optional<AfterLoss> after_loss(std::span<const Vec3> x, std::span<const Vec3> reference, double threshold,
                                    std::int64_t window) {
  TACTOR_DEMAND(x.size() == reference.size());
  std::optional<AfterLoss> result;
  const auto length = static_cast<std::size_t>(window);
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double before = norm(reference[i - 1]);
    if (before <= threshold || norm(reference[i]) > threshold) continue;
    if (!result) result.emplace();
    const Vec3 direction = reference[i - 1] / before;
    const std::size_t end = std::min(x.size(), i + length);
    for (std::size_t j = i; j < end && norm(reference[j]) <= threshold; ++j) {
      const double shown = dot(x[j], direction);
      const double wanted = dot(reference[j], direction);
      result->overshoot = std::max(result->overshoot, std::max(0.0, -shown) - std::max(0.0, -wanted));
      if (j >= i + length / 2) result->ghost = std::max(result->ghost, shown - wanted);
    }
  }
  return result;
}

}  // namespace tactor
