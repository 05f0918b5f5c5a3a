// The newest samples of the handle, as nodes keep them that step through each.
#pragma once

#include <array>

#include "framework/core/messages.hpp"
#include "framework/node/new_messages.hpp"
#include "nodes/physics/mechanics/handle.hpp"

namespace tactor {

/// The last `Capacity` usable samples of the handle, with normalised rotations, in the order of their times. Those that
/// are not finite, or no later than the one before, are left out and counted.
template <std::size_t Capacity>
class HandleTrack {
 public:
  static constexpr std::size_t capacity = Capacity;

  void take(Input<DeviceState>& device) {
    Stamped<DeviceState> s;
    while (new_states_.next(device, s)) {
      const bool later = count_ == 0 || s.stamp.valid > newest().stamp.valid;
      if (later && is_usable(s.value)) {
        s.value.X_WD.R = normalized(s.value.X_WD.R);
        samples_[count_++ % Capacity] = s;
      } else {
        ++rejected_;
      }
    }
  }

  /// Samples taken so far; those from `first()` on are known.
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t first() const { return count_ > Capacity ? count_ - Capacity : 0; }
  /// Sample number k of those taken, first() <= k < count().
  [[nodiscard]] const Stamped<DeviceState>& operator[](std::size_t k) const { return samples_[k % Capacity]; }
  [[nodiscard]] const Stamped<DeviceState>& newest() const { return (*this)[count_ - 1]; }
  [[nodiscard]] std::int64_t rejected() const { return rejected_; }

  /// m/s^2 and rad/s^2, of the handle over the last five samples; zero where there are fewer.
  [[nodiscard]] Twist acceleration() const {
    constexpr std::size_t span = 5;
    static_assert(span < Capacity);
    if (count_ <= span) return {};
    const Stamped<DeviceState>&a = (*this)[count_ - 1 - span], &b = newest();
    const double per_second = 1 / (b.stamp.valid - a.stamp.valid).seconds();
    return {per_second * (b.value.V_WD.v - a.value.V_WD.v), per_second * (b.value.V_WD.w - a.value.V_WD.w)};
  }

 private:
  NewMessages<DeviceState> new_states_;
  std::array<Stamped<DeviceState>, Capacity> samples_;
  std::size_t count_ = 0;
  std::int64_t rejected_ = 0;
};

}  // namespace tactor
