// Durations counted in fixed memory, fine enough for percentiles and cheap enough for every tick.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/time.hpp"

namespace tactor {

namespace log_linear {

inline constexpr int cut_bits = 6;
inline constexpr std::int64_t cuts = 1 << cut_bits;

/// The bucket that counts durations of `ns` >= 1 nanoseconds.
constexpr std::size_t bucket_of(std::int64_t ns) noexcept {
  if (ns < cuts) return static_cast<std::size_t>(ns);
  const int shift = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(ns))) - 1 - cut_bits;
  return static_cast<std::size_t>(shift * cuts + (ns >> shift));
}

/// The middle of a bucket in nanoseconds.
constexpr std::int64_t middle_of(std::size_t bucket) noexcept {
  const auto index = static_cast<std::int64_t>(bucket);
  if (index < 2 * cuts) return index;
  const std::int64_t shift = index / cuts - 1;
  return ((index - shift * cuts) << shift) + (std::int64_t{1} << shift) / 2;
}

}  // namespace log_linear

/// A log-linear histogram: each power of two of nanoseconds is cut into 64 equal buckets, so a bucket is at most 1/64
/// of its values wide and a quantile is off by at most 0.8 %; below 128 ns it is exact. 16 KiB, whatever it counts.
///
/// One thread writes, any thread may read meanwhile and sees counts that are each a moment old. Writing is plain loads
/// and stores: no locked instruction. Memory is touched by the constructor.
class LatencyHistogram {
 public:
  /// What a duration is clamped to before it is counted; `max` keeps it as it was.
  static constexpr Duration least{1};
  static constexpr Duration most{100'000'000'000};

  LatencyHistogram() noexcept {
    // Written rather than left to zeroed pages of the system, which would fault in at the first use of each.
    for (auto& bucket : counts_) bucket.store(0, std::memory_order_relaxed);
  }
  LatencyHistogram(const LatencyHistogram& other) noexcept : LatencyHistogram() { merge(other); }
  LatencyHistogram& operator=(const LatencyHistogram&) = delete;

  /// Writer: counts one duration.
  void record(Duration d) noexcept {
    if (count() == 0 || d > max()) max_.store(d.ns, std::memory_order_relaxed);
    add(counts_[log_linear::bucket_of(std::clamp(d, least, most).ns)], 1);
    add(count_, 1);
  }

  /// Writer: adds what another histogram has counted.
  void merge(const LatencyHistogram& other) noexcept {
    const std::uint64_t others = other.count();
    if (others == 0) return;
    if (count() == 0 || other.max() > max()) max_.store(other.max().ns, std::memory_order_relaxed);
    for (std::size_t i = 0; i < counts_.size(); ++i) add(counts_[i], other.counts_[i].load(std::memory_order_relaxed));
    add(count_, others);
  }

  /// The number of durations recorded.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  /// The longest, exactly, unclamped; 0 where nothing was recorded.
  [[nodiscard]] Duration max() const noexcept { return {max_.load(std::memory_order_relaxed)}; }

  /// The duration at rank ceil(q * count) of the sorted durations, at least rank 1 (the nearest-rank quantile), told as
  /// the middle of its bucket but never beyond `max`; q = 1 is `max` itself. `q` in [0, 1]. 0 where nothing was
  /// recorded. Reads all buckets.
  [[nodiscard]] Duration quantile(double q) const noexcept {
    TACTOR_DEMAND(q >= 0 && q <= 1);
    if (q == 1) return max();
    // The sum of the buckets and not `count`, which the writer may meanwhile have taken further.
    std::uint64_t total = 0;
    for (const auto& bucket : counts_) total += bucket.load(std::memory_order_relaxed);
    const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(q * static_cast<double>(total))));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      seen += counts_[i].load(std::memory_order_relaxed);
      if (seen >= rank) return std::min(Duration{log_linear::middle_of(i)}, std::max(max(), least));
    }
    return max();
  }

  /// The buckets that are not empty, from the shortest on: the middle of each and its count. Allocates.
  [[nodiscard]] std::vector<std::pair<Duration, std::uint64_t>> counts() const {
    std::vector<std::pair<Duration, std::uint64_t>> result;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const std::uint64_t n = counts_[i].load(std::memory_order_relaxed);
      if (n > 0) result.emplace_back(Duration{log_linear::middle_of(i)}, n);
    }
    return result;
  }

 private:
  template <class Counter, class Value>
  static void add(Counter& counter, Value value) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + value, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint64_t>, log_linear::bucket_of(most.ns) + 1> counts_;
  std::atomic<std::uint64_t> count_{0};
  std::atomic<std::int64_t> max_{0};
};

}  // namespace tactor
