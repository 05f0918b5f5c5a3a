// The handle between two of its samples.
#pragma once

#include "framework/core/between_samples.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// The handle at share s of the way from a to b: steady motion along the line and, where `rotates`, about the shorter
/// turn. Velocities go linearly; all else is b's.
inline DeviceState handle_between(const DeviceState& a, const DeviceState& b, double s, bool rotates) {
  DeviceState d = b;
  d.V_WD.v = between(a.V_WD.v, b.V_WD.v, s);
  if (rotates) {
    d.X_WD = between(a.X_WD, b.X_WD, s);
    d.V_WD.w = between(a.V_WD.w, b.V_WD.w, s);
  } else {
    d.X_WD.p = between(a.X_WD.p, b.X_WD.p, s);
  }
  return d;
}

}  // namespace tactor
