// A rigid motion between two known states.
#pragma once

#include "framework/core/spatial.hpp"

namespace tactor {

/// A pose and its velocity, both in W.
struct MotionState {
  Pose X;
  Twist V;
};

/// The state at the share s in [0, 1] of the `dt` seconds from `a` to `b`: the cubic Hermite of position, and of the
/// rotation vector relative to a.X.R. The latter takes w as the rate of that vector, good for the small arcs of one
/// tick. `rotate` false: the rotation of `b`, angular velocity zero.
MotionState interpolate(const MotionState& a, const MotionState& b, double dt, double s, bool rotate);

}  // namespace tactor
