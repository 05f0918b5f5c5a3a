// When and how the tool touches, which an effect answers to.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "framework/core/messages.hpp"
#include "framework/node/new_messages.hpp"
#include "framework/node/port.hpp"

namespace tactor {

/// How a surface pushes.
struct Touch {
  bool touches = false;
  Vec3 force_W;  ///< N, of the surface on the tool; its direction is taken for the surface's normal
  Time at;       ///< the time of the handle's sample that led to that force
};

/// Where `contact` is connected, what its newest message says; before the first nothing touches. Else the force that is
/// displayed, `displayed_W` (N), is taken for that of a surface where its norm is above `threshold` (N).
inline Touch touch_of(const Input<PhysicsState>& contact, const Input<DeviceState>& device, const Vec3& displayed_W,
                      double threshold) {
  if (contact.connected()) {
    const Stamped<PhysicsState>* state = contact.latest();
    if (state == nullptr || !is_finite(state->value.contact_T_W.force)) return {};
    return {state->value.contacts > 0, state->value.contact_T_W.force, state->stamp.valid};
  }
  const Stamped<DeviceState>* handle = device.latest();
  return {norm(displayed_W) > threshold, displayed_W, handle != nullptr ? handle->stamp.valid : Time{}};
}

/// How fast the handle was. What physics says of its handle is not that: a line of waves stands in for the handle
/// there.
class HandleSpeeds {
 public:
  /// Takes every sample that has come and is later than the one before.
  void take(Input<DeviceState>& device) {
    Stamped<DeviceState> sample;
    while (samples_.next(device, sample)) {
      if (count_ > 0 && sample.stamp.valid <= at(count_ - 1).at) continue;
      if (count_ == kept) {
        begin_ = (begin_ + 1) % kept;
        --count_;
      }
      ++count_;
      speeds_[(begin_ + count_ - 1) % kept] = {sample.stamp.valid, sample.value.V_WD.v};
    }
  }
  /// m/s, of the last sample that is not later than `time`; not finite where there is none.
  [[nodiscard]] Vec3 by(Time time) const {
    for (std::size_t i = count_; i > 0; --i) {
      if (at(i - 1).at <= time) return at(i - 1).v_WD;
    }
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    return {unknown, unknown, unknown};
  }

 private:
  static constexpr std::size_t kept = 1024;
  struct Speed {
    Time at;
    Vec3 v_WD;
  };
  [[nodiscard]] const Speed& at(std::size_t i) const { return speeds_[(begin_ + i) % kept]; }

  NewMessages<DeviceState> samples_;
  std::array<Speed, kept> speeds_{};  // a ring: `count_` entries from `begin_` on
  std::size_t begin_ = 0, count_ = 0;
};

/// Contact begins when the tool touches after it has not for `quiet`. So a force that flutters about a threshold, and a
/// handle that the effect itself pushes out of the surface, begin nothing.
class ContactOnset {
 public:
  explicit ContactOnset(Duration quiet) : quiet_(quiet) {}

  /// True where a contact begins now; times do not fall.
  bool begins(Time now, bool touches) {
    const bool begin = touches && !touched_ && (!any_ || now - left_ >= quiet_);
    if (touches) {
      left_ = now;
      any_ = true;
    }
    touched_ = touches;
    return begin;
  }

 private:
  Duration quiet_;
  Time left_;  // when it last touched
  bool any_ = false, touched_ = false;
};

}  // namespace tactor
