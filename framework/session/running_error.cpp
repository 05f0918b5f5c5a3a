#include "framework/session/running_error.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/between_samples.hpp"
#include "framework/core/signal_metrics.hpp"

namespace tactor {

namespace {

constexpr Duration kept{2'000'000'000};
constexpr Duration lately{1'000'000'000};
constexpr Duration longest_delay{100'000'000};

}  // namespace

void RunningError::add_true(Time t, const Wrench& force) {
  if (is_finite(force) && (true_.empty() || t > true_.back().t)) true_.push_back({t, force.force});
}

void RunningError::add_displayed(Time t, const Wrench& force) {
  if (is_finite(force) && (displayed_.empty() || t > displayed_.back().t)) displayed_.push_back({t, force.force});
}

void RunningError::begin_again(Time from) {
  compare();
  true_.clear();
  while (!displayed_.empty() && displayed_.front().t < from) displayed_.pop_front();
  times_.clear();
  x_.clear();
  reference_.clear();
  from_ = from;
}

void RunningError::count_anew(Time from) {
  times_.clear();
  x_.clear();
  reference_.clear();
  from_ = std::max(from_, from);
  count_ = 0;
  covered_ = {};
  sum_of_squares_ = 0;
  largest_ = 0;
}

Vec3 RunningError::true_at(Time t) {
  std::size_t gone = 0;
  const Vec3 force = value_between(true_, t, gone, &Sample::t, &Sample::force);
  true_.erase(true_.begin(), true_.begin() + static_cast<std::ptrdiff_t>(gone));
  return force;
}

void RunningError::compare() {
  for (; !displayed_.empty() && !true_.empty() && displayed_.front().t <= true_.back().t; displayed_.pop_front()) {
    const Sample& shown = displayed_.front();
    // Before the first true sample nothing is known.
    if (shown.t < from_ || shown.t < true_.front().t) continue;
    const Vec3 truth = true_at(shown.t);
    const double error = norm(shown.force - truth);
    ++count_;
    sum_of_squares_ += error * error;
    largest_ = std::max(largest_, error);
    if (!times_.empty()) covered_ = covered_ + (shown.t - times_.back());
    times_.push_back(shown.t);
    x_.push_back(shown.force);
    reference_.push_back(truth);
    while (shown.t - times_.front() > kept) {
      times_.pop_front();
      x_.pop_front();
      reference_.pop_front();
    }
  }
}

ErrorFigures RunningError::figures() const {
  ErrorFigures figures;
  figures.compared = count_;
  if (count_ == 0) return figures;
  figures.rms_N = std::sqrt(sum_of_squares_ / static_cast<double>(count_));
  figures.max_N = largest_;
  figures.covered = covered_;
  if (times_.empty()) return figures;
  figures.until = times_.back();
  const std::vector<Vec3> x(x_.begin(), x_.end()), reference(reference_.begin(), reference_.end());
  const auto newer = std::find_if(times_.begin(), times_.end(), [this](Time t) { return times_.back() - t <= lately; });
  const auto first = static_cast<std::size_t>(newer - times_.begin());
  figures.rms_lately_N = rms_error(std::span(x).subspan(first), std::span(reference).subspan(first));
  if (times_.size() < 2) return figures;
  // Samples come at the rate of the device; one that was missed shifts nothing that could be seen.
  const double step = (times_.back() - times_.front()).seconds() / static_cast<double>(times_.size() - 1);
  const std::int64_t change = std::max(1LL, std::llround(delay_change_time_s / step));
  const auto late = delay_of_changes(x, reference, std::llround(longest_delay.seconds() / step), change);
  if (late && is_explained_by(*late, x, reference)) figures.delay = Duration::from_seconds(*late * step);
  return figures;
}

std::optional<FeltLately> RunningError::felt(double handle_mass) const {
  const auto newer = std::find_if(times_.begin(), times_.end(), [this](Time t) { return times_.back() - t <= lately; });
  const auto first = newer - times_.begin();
  const std::vector<Vec3> x(x_.begin() + first, x_.end()), reference(reference_.begin() + first, reference_.end());
  if (x.size() < 2) return std::nullopt;
  const double rate = static_cast<double>(x.size() - 1) / (times_.back() - *newer).seconds();
  return FeltLately{share_beyond_weber(x, reference), felt_vibration(x, reference, rate, handle_mass)};
}

}  // namespace tactor
