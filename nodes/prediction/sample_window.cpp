#include "nodes/prediction/sample_window.hpp"

#include <algorithm>
#include <limits>

#include "nodes/prediction/autoregression.hpp"

namespace tactor {

Vec3 mean(const SampleWindow<Vec3>& window, std::size_t count) {
  const std::size_t n = std::min(count, window.size());
  if (n == 0) return {};
  Vec3 sum;
  for (std::size_t age = 0; age < n; ++age) sum += window[age];
  return sum / static_cast<double>(n);
}

AutocovarianceWindow::AutocovarianceWindow(std::size_t window, std::size_t lags, bool remove_mean)
    : window_(window), remove_mean_(remove_mean), sums_(lags, 0.0), ordered_(window) {
  TACTOR_DEMAND(lags >= 1 && lags <= window);
}

void AutocovarianceWindow::push(const Vec3& x) {
  if (remove_mean_) {
    window_.push(x);
    return;
  }
  if (window_.full()) subtract_oldest();
  window_.push(x);
  const std::size_t lags = std::min(sums_.size(), window_.size());
  for (std::size_t k = 0; k < lags; ++k) sums_[k] += dot(x, window_[k]);
  peak_ = std::max(peak_, sums_[0]);
  ++since_afresh_;
  refresh_sums();
}

void AutocovarianceWindow::drop_oldest() {
  if (!remove_mean_) subtract_oldest();
  window_.drop_oldest();
  if (!remove_mean_) refresh_sums();
}

void AutocovarianceWindow::subtract_oldest() {
  const std::size_t oldest = window_.size() - 1;
  const Vec3& leaving = window_[oldest];
  const std::size_t lags = std::min(sums_.size(), window_.size());
  for (std::size_t k = 0; k < lags; ++k) sums_[k] -= dot(leaving, window_[oldest - k]);
}

void AutocovarianceWindow::refresh_sums() {
  // The rounding left in the sums is relative to the peak; four digits of fall leave twelve.
  constexpr double fallen = 1e-4;
  if (since_afresh_ >= window_.capacity() || sums_[0] < fallen * peak_) sum_afresh();
}

void AutocovarianceWindow::sum_afresh() {
  since_afresh_ = 0;
  const std::size_t n = window_.size();
  for (std::size_t i = 0; i < n; ++i) ordered_[i] = window_[n - 1 - i];
  autocovariance(std::span<const Vec3>(ordered_).first(n), {}, sums_);
  for (double& s : sums_) s *= static_cast<double>(n);
  peak_ = sums_[0];
}

void AutocovarianceWindow::covariances(std::span<double> r) {
  TACTOR_ASSERT(size() > 0 && r.size() <= sums_.size());
  const std::size_t n = window_.size();
  if (!remove_mean_) {
    for (std::size_t k = 0; k < r.size(); ++k) r[k] = sums_[k] / static_cast<double>(n);
    noise_ = 0;
    return;
  }
  for (std::size_t i = 0; i < n; ++i) ordered_[i] = window_[n - 1 - i];
  mean_ = mean(window_, n);
  autocovariance(std::span<const Vec3>(ordered_).first(n), mean_, r);
  // The mean is known to about n epsilon |x|; the square of that is what a constant signal leaves.
  const double rounding = static_cast<double>(n) * std::numeric_limits<double>::epsilon();
  noise_ = rounding * rounding * (dot(mean_, mean_) + r[0]);
}

void AutocovarianceWindow::edges(std::span<Vec3> first, std::span<Vec3> last) const {
  TACTOR_ASSERT(first.size() <= size() && last.size() <= size());
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = window_[size() - 1 - i] - mean_;
  for (std::size_t i = 0; i < last.size(); ++i) last[i] = window_[i] - mean_;
}

}  // namespace tactor
