// How a segment goes on from what is displayed: value, rate and curvature of a force at one time, and polynomials
// between two of them.
#pragma once

#include <cmath>

#include "framework/core/messages.hpp"
#include "framework/core/segment.hpp"

namespace tactor {

/// A force and its time derivatives at one time.
struct ForceState {
  Wrench value;      ///< N, N m
  Wrench rate;       ///< N/s, N m/s
  Wrench curvature;  ///< N/s^2, N m/s^2
};

inline ForceState operator+(const ForceState& a, const ForceState& b) {
  return {a.value + b.value, a.rate + b.rate, a.curvature + b.curvature};
}
inline ForceState operator-(const ForceState& a, const ForceState& b) {
  return {a.value - b.value, a.rate - b.rate, a.curvature - b.curvature};
}

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

/// The difference e after h seconds of a decay with two equal poles, tau^2 e'' + 2 tau e' + e = 0:
///   e(h) = (e + b h) exp(-h / tau), e'(h) = (e' - b h / tau) exp(-h / tau), b = e' + e / tau.
/// The curvature that comes in is of no meaning, the one that goes out is zero.
inline ForceState decayed_twice(const ForceState& e, double h, double tau) {
  const double decay = std::exp(-h / tau);
  const Wrench b = e.rate + (1.0 / tau) * e.value;
  return {decay * (e.value + h * b), decay * (e.rate - (h / tau) * b), {}};
}

/// The difference e after h seconds of a decay with three equal poles, (tau d/dt + 1)^3 e = 0:
///   e(h) = (e + b h + c h^2 / 2) exp(-h / tau), b = e' + e / tau, c = e'' + 2 e' / tau + e / tau^2.
inline ForceState decayed_thrice(const ForceState& e, double h, double tau) {
  const double decay = std::exp(-h / tau);
  const double w = 1.0 / tau;
  const Wrench b = e.rate + w * e.value;
  const Wrench c = e.curvature + (2.0 * w) * e.rate + (w * w) * e.value;
  // The polynomial and its derivatives at h.
  const Wrench p = e.value + h * b + (0.5 * h * h) * c;
  const Wrench dp = b + h * c;
  return {decay * p, decay * (dp - w * p), decay * (c - (2.0 * w) * dp + (w * w) * p)};
}

}  // namespace tactor
