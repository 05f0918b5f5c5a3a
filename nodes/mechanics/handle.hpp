// The handle between two of its samples.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// The handle at share s of the way from a to b: steady motion along the line and, where `rotates`, about the shorter
/// turn. Velocities go linearly; all else is b's.
inline DeviceState handle_between(const DeviceState& a, const DeviceState& b, double s, bool rotates) {
  DeviceState d = b;
  d.X_WD.p = a.X_WD.p + s * (b.X_WD.p - a.X_WD.p);
  d.V_WD.v = a.V_WD.v + s * (b.V_WD.v - a.V_WD.v);
  if (rotates) {
    const Vec3 turn = to_rotation_vector(b.X_WD.R * inverse(a.X_WD.R));
    d.X_WD.R = from_rotation_vector(s * turn) * a.X_WD.R;
    d.V_WD.w = a.V_WD.w + s * (b.V_WD.w - a.V_WD.w);
  }
  return d;
}

}  // namespace tactor
