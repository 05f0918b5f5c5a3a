// Evaluation of a force segment: value and time derivatives of its cubic, held before it begins and after it ends.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// s = (t - begin) / (end - begin), clamped to [0, 1]; 1 from the begin on where the segment has no length.
inline double normalised_time(const ForceSegment& segment, Time t) {
  if (t >= segment.end) return 1.0;
  if (t <= segment.begin) return 0.0;
  return static_cast<double>((t - segment.begin).ns) / static_cast<double>((segment.end - segment.begin).ns);
}

/// F(t) = c[0] + c[1] s + c[2] s^2 + c[3] s^3 in N and N m, in the frame of the coefficients; F(begin) before `begin`
/// and F(end) from `end` on. Allocates nothing and throws nothing.
inline Wrench evaluate(const ForceSegment& segment, Time t) {
  const double s = normalised_time(segment, t);
  return segment.c[0] + s * (segment.c[1] + s * (segment.c[2] + s * segment.c[3]));
}

/// dF/dt in N/s and N m/s; zero before `begin`, and from `end` on because the value is held there.
inline Wrench evaluate_rate(const ForceSegment& segment, Time t) {
  if (t < segment.begin || t >= segment.end) return {};
  const double s = normalised_time(segment, t);
  const double per_second = 1.0 / (segment.end - segment.begin).seconds();
  return per_second * (segment.c[1] + s * (2.0 * segment.c[2] + 3.0 * s * segment.c[3]));
}

/// d^2F/dt^2 in N/s^2 and N m/s^2; zero before `begin` and from `end` on.
inline Wrench evaluate_curvature(const ForceSegment& segment, Time t) {
  if (t < segment.begin || t >= segment.end) return {};
  const double s = normalised_time(segment, t);
  const double per_second = 1.0 / (segment.end - segment.begin).seconds();
  return per_second * per_second * (2.0 * segment.c[2] + 6.0 * s * segment.c[3]);
}

/// The segment that holds `value` from `begin` on.
inline ForceSegment constant_segment(Time begin, const Wrench& value) {
  return {begin, begin, {value}};
}

}  // namespace tactor
