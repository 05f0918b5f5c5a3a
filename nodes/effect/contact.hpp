// When and how the tool touches, which an effect answers to.
#pragma once

#include <limits>

#include "framework/core/messages.hpp"
#include "framework/node/port.hpp"

namespace tactor {

/// How a surface pushes.
struct Touch {
  bool touches = false;
  Vec3 force_W;  ///< N, of the surface on the tool; its direction is taken for the surface's normal
  Vec3 v_WD;     ///< m/s, of the handle at the time of that force; not finite where nobody knows
};

/// Where `contact` is connected, what its newest message says; before the first nothing touches. Else the force that is
/// displayed, `displayed_W` (N), is taken for that of a surface where its norm is above `threshold` (N).
inline Touch touch_of(const Input<PhysicsState>& contact, const Input<DeviceState>& device, const Vec3& displayed_W,
                      double threshold) {
  if (contact.connected()) {
    const Stamped<PhysicsState>* state = contact.latest();
    if (state == nullptr || !is_finite(state->value.contact_T_W.force)) return {};
    return {state->value.contacts > 0, state->value.contact_T_W.force, state->value.V_WD.v};
  }
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const Stamped<DeviceState>* handle = device.latest();
  return {norm(displayed_W) > threshold, displayed_W,
          handle != nullptr ? handle->value.V_WD.v : Vec3{unknown, unknown, unknown}};
}

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
