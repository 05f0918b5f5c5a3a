// The last N vector samples in a ring, and their autocovariance kept up to date sample by sample.
#pragma once

#include <span>
#include <vector>

#include "framework/core/between_samples.hpp"
#include "framework/core/check.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// The last `capacity` values; storage is allocated once.
template <class T>
class SampleWindow {
 public:
  explicit SampleWindow(std::size_t capacity) : samples_(capacity) { TACTOR_DEMAND(capacity > 0); }

  void push(const T& x) {
    newest_ = newest_ + 1 == samples_.size() ? 0 : newest_ + 1;
    samples_[newest_] = x;
    if (size_ < samples_.size()) ++size_;
  }
  /// Forgets the oldest value; needs size() > 0.
  void drop_oldest() {
    TACTOR_ASSERT(size_ > 0);
    --size_;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return samples_.size(); }
  [[nodiscard]] bool full() const { return size_ == samples_.size(); }
  /// The value that came `age` values before the newest; needs age < size().
  [[nodiscard]] const T& operator[](std::size_t age) const {
    return samples_[age <= newest_ ? newest_ - age : newest_ + samples_.size() - age];
  }
  [[nodiscard]] const T& oldest() const { return (*this)[size_ - 1]; }

 private:
  std::vector<T> samples_;
  std::size_t newest_ = 0;
  std::size_t size_ = 0;
};

/// Where a time lies among stamped samples: `share` of the way from the one of `age` to the next newer one.
struct SamplePlace {
  std::size_t age = 0;
  double share = 0;
};

/// Finds t among the stamps, from place.age on towards older samples; the newest, share 0, where t is later than all.
/// False where t is before all of them. With times that fall the search goes on from the place found before.
template <class T>
bool find_place(const SampleWindow<Stamped<T>>& samples, Time t, SamplePlace& place) {
  std::size_t age = place.age;
  while (age < samples.size() && samples[age].stamp.valid > t) ++age;
  if (age == samples.size()) return false;
  place = {age, 0.0};
  if (age == 0) return true;
  place.share = share_between(samples[age].stamp.valid, samples[age - 1].stamp.valid, t);
  return true;
}

/// The mean of the newest `count` samples, or of all where there are fewer, summed afresh; zero where there are none.
Vec3 mean(const SampleWindow<Vec3>& window, std::size_t count);

/// A window with its biased autocovariance (see autocovariance()). Without removal of a mean a sample costs two scalar
/// products a lag: the products with the sample that leaves go, those with the one that comes are added. Rounding stays
/// bounded, because the sums are made afresh once a window, and at once where they have fallen far below what they
/// were.
class AutocovarianceWindow {
 public:
  /// `lags` autocovariances, r[0] to r[lags - 1], of the last `window` samples; needs 1 <= lags <= window.
  AutocovarianceWindow(std::size_t window, std::size_t lags, bool remove_mean);

  /// Needs a sample whose square is finite.
  void push(const Vec3& x);
  /// Takes the oldest sample out of the window; needs size() > 0.
  void drop_oldest();
  [[nodiscard]] bool full() const { return window_.full(); }
  [[nodiscard]] std::size_t size() const { return window_.size(); }
  [[nodiscard]] std::size_t capacity() const { return window_.capacity(); }
  /// Writes r of the samples that are there; needs size() > 0 and r.size() <= lags.
  void covariances(std::span<double> r);
  /// Writes the first and the last samples, as they were at covariances() (less the mean, where it is removed):
  /// first[i] = x_i, last[i] = x_{N-1-i}. Needs size() >= the sizes of both.
  void edges(std::span<Vec3> first, std::span<Vec3> last) const;
  /// The energy that removal of the mean can leave by rounding, for has_energy(); of the last covariances().
  [[nodiscard]] double noise() const { return noise_; }

 private:
  void subtract_oldest();
  void refresh_sums();
  void sum_afresh();

  SampleWindow<Vec3> window_;
  bool remove_mean_;
  std::vector<double> sums_;
  std::vector<Vec3> ordered_;
  double peak_ = 0;  // the largest energy sum since the sums were made afresh
  std::size_t since_afresh_ = 0;
  Vec3 mean_;
  double noise_ = 0;
};

}  // namespace tactor
