// How a segment goes on from what is displayed: value, rate and curvature of a force at one time, and polynomials
// between two of them.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/core/segment.hpp"

namespace tactor {

/// A force and its time derivatives at one time.
struct ForceState {
  Wrench value;      ///< N, N m
  Wrench rate;       ///< N/s, N m/s
  Wrench curvature;  ///< N/s^2, N m/s^2
};

/// What a device that was sent `segment` last displays at `now`. At the very end of the segment it still moves; later
/// the value is held, at rest.
inline ForceState displayed(const ForceSegment& segment, Time now) {
  if (now != segment.end || segment.end <= segment.begin) {
    return {evaluate(segment, now), evaluate_rate(segment, now), evaluate_curvature(segment, now)};
  }
  const double per_second = 1.0 / (segment.end - segment.begin).seconds();
  const auto& c = segment.c;
  return {evaluate(segment, now), per_second * (c[1] + 2.0 * c[2] + 3.0 * c[3] + 4.0 * c[4] + 5.0 * c[5]),
          (per_second * per_second) * (2.0 * c[2] + 6.0 * c[3] + 12.0 * c[4] + 20.0 * c[5])};
}

/// The cubic with the values and rates of `from` at `begin` and of `to` one `length` > 0 later.
inline ForceSegment cubic_between(Time begin, Duration length, const ForceState& from, const ForceState& to) {
  const double T = length.seconds();
  const Wrench change = to.value - from.value;
  const Wrench v0 = T * from.rate;
  const Wrench v1 = T * to.rate;
  return {begin, begin + length, {from.value, v0, 3.0 * change - 2.0 * v0 - v1, v0 + v1 - 2.0 * change}};
}

/// The quintic with the values, rates and curvatures of `from` at `begin` and of `to` one `length` > 0 later.
inline ForceSegment quintic_between(Time begin, Duration length, const ForceState& from, const ForceState& to) {
  const double T = length.seconds();
  const Wrench v0 = T * from.rate;
  const Wrench a0 = (0.5 * T * T) * from.curvature;
  // What is left of the end's value, slope and curvature beyond those of the parabola that `from` begins.
  const Wrench x = to.value - from.value - v0 - a0;
  const Wrench v = T * to.rate - v0 - 2.0 * a0;
  const Wrench a = (T * T) * to.curvature - 2.0 * a0;
  return {begin,
          begin + length,
          {from.value, v0, a0, 10.0 * x - 4.0 * v + 0.5 * a, 7.0 * v - 15.0 * x - a, 6.0 * x - 3.0 * v + 0.5 * a}};
}

}  // namespace tactor
