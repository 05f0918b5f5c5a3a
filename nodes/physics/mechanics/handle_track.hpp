// The newest samples of the handle, as nodes keep them that step through each.
#pragma once

#include <algorithm>
#include <array>

#include "framework/core/handle_between.hpp"
#include "framework/core/handle_gate.hpp"
#include "framework/core/messages.hpp"
#include "framework/node/new_messages.hpp"

namespace tactor {

/// The last `Capacity` samples of the handle that HandleGate admits.
template <std::size_t Capacity>
class HandleTrack {
 public:
  void take(Input<DeviceState>& device) {
    Stamped<DeviceState> s;
    while (new_states_.next(device, s)) {
      if (gate_.admit(s)) samples_[count_++ % Capacity] = s;
    }
  }

  /// Samples taken so far; those from `first()` on are known.
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t first() const { return count_ > Capacity ? count_ - Capacity : 0; }
  /// Sample number k of those taken, first() <= k < count().
  [[nodiscard]] const Stamped<DeviceState>& operator[](std::size_t k) const { return samples_[k % Capacity]; }
  [[nodiscard]] const Stamped<DeviceState>& newest() const { return (*this)[count_ - 1]; }
  /// Number of the first known sample later than t; count() where there is none.
  [[nodiscard]] std::size_t after(Time t) const {
    std::size_t k = count_;
    while (k > first() && (*this)[k - 1].stamp.valid > t) --k;
    return k;
  }
  /// The handle at t: a sample where one is of that time, else between the two around (handle_between), or the nearest
  /// where t is before or after all that are known; needs count() > 0.
  [[nodiscard]] DeviceState at(Time t, bool rotates) const {
    const std::size_t k = after(t);
    const Stamped<DeviceState>& a = (*this)[std::max(k, first() + 1) - 1];
    if (k == count_ || a.stamp.valid >= t) return a.value;
    const Stamped<DeviceState>& b = (*this)[k];
    return handle_between(a.value, b.value, share_between(a.stamp.valid, b.stamp.valid, t), rotates);
  }
  [[nodiscard]] std::uint64_t rejected() const { return gate_.refusals().refused(); }

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
  HandleGate gate_;
  std::array<Stamped<DeviceState>, Capacity> samples_;
  std::size_t count_ = 0;
};

}  // namespace tactor
