// Limits the work that a client may ask for.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace tactor {

/// A stock of work that fills up with time. Work is counted in bytes: of a request, and of what it makes the server
/// send once more. A client that has used up its stock is not cut off: its next request is read later.
class RequestMeter {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::int64_t a_second = std::int64_t{1} << 20U;      ///< bytes
  static constexpr std::int64_t stock = a_second;                       ///< bytes at most, and at first
  static constexpr std::int64_t of_a_request = std::int64_t{8} << 10U;  ///< bytes, for a request of any size

  explicit RequestMeter(Clock::time_point now) : at_(now) {}

  /// A request of so many bytes was carried out. Returns how long the next one has to wait; 0 where there is stock.
  Clock::duration spend(std::uint64_t bytes, Clock::time_point now) {
    const double gained = std::chrono::duration<double>(now - at_).count() * static_cast<double>(a_second);
    left_ = std::min(left_ + gained, static_cast<double>(stock));
    left_ -= static_cast<double>(bytes) + static_cast<double>(of_a_request);
    at_ = now;
    const double lacking = std::max(-left_, 0.0) / static_cast<double>(a_second);
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(lacking));
  }

 private:
  double left_ = static_cast<double>(stock);  // bytes
  Clock::time_point at_;
};

}  // namespace tactor
