// Leads a handle after a cursor: in bounded speed, without steps of its velocity.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// A critically damped filter of second order behind a limit of speed. The goal goes towards the cursor in a straight
/// line at no more than the largest speed; the handle follows it by x'' = w^2 (goal - x) - 2 w x', w = 1 /
/// time_constant, integrated exactly for a goal that stands still. Its impulse response is positive and of area 1, so
/// that the handle is never faster than the goal. Rotation alike, by the rotation vector.
class CursorFilter {
 public:
  struct Limits {
    double time_constant = 0;  ///< s, above 0
    double speed = 0;          ///< m/s, largest of the handle
    double angular_speed = 0;  ///< rad/s
  };
  CursorFilter(const Limits& limits, const Pose& start) : limits_(limits), goal_(start) { state_.X = start; }

  struct State {
    Pose X;   ///< m
    Twist V;  ///< m/s, rad/s
  };
  [[nodiscard]] const State& state() const { return state_; }
  /// Lets `seconds` >= 0 pass towards `cursor`, whose orientation is a unit quaternion.
  void advance(double seconds, const Pose& cursor, bool rotates);

 private:
  Limits limits_;
  Pose goal_;
  State state_;
};

}  // namespace tactor
