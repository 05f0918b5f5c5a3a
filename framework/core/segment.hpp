// Evaluation of a force segment: value and time derivatives of its quintic, held before it begins and after it ends.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// s = (t - begin) / (end - begin), clamped to [0, 1]; 1 from the begin on where the segment has no length.
inline double normalised_time(const ForceSegment& segment, Time t) {
  if (t >= segment.end) return 1.0;
  if (t <= segment.begin) return 0.0;
  return static_cast<double>((t - segment.begin).ns) / static_cast<double>((segment.end - segment.begin).ns);
}

/// F(t) = c[0] + c[1] s + ... + c[5] s^5 in N and N m, in the frame of the coefficients; F(begin) before `begin`
/// and F(end) from `end` on. Allocates nothing and throws nothing.
inline Wrench evaluate(const ForceSegment& segment, Time t) {
  const double s = normalised_time(segment, t);
  const auto& c = segment.c;
  return c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))));
}

/// dF/dt in N/s and N m/s; zero before `begin`, and from `end` on because the value is held there.
inline Wrench evaluate_rate(const ForceSegment& segment, Time t) {
  if (t < segment.begin || t >= segment.end) return {};
  const double s = normalised_time(segment, t);
  const double per_second = 1.0 / (segment.end - segment.begin).seconds();
  const auto& c = segment.c;
  return per_second * (c[1] + s * (2.0 * c[2] + s * (3.0 * c[3] + s * (4.0 * c[4] + (5.0 * s) * c[5]))));
}

/// d^2F/dt^2 in N/s^2 and N m/s^2; zero before `begin` and from `end` on.
inline Wrench evaluate_curvature(const ForceSegment& segment, Time t) {
  if (t < segment.begin || t >= segment.end) return {};
  const double s = normalised_time(segment, t);
  const double per_second = 1.0 / (segment.end - segment.begin).seconds();
  const auto& c = segment.c;
  return (per_second * per_second) * (2.0 * c[2] + s * (6.0 * c[3] + s * (12.0 * c[4] + (20.0 * s) * c[5])));
}

/// The segment that holds `value` from `begin` on.
inline ForceSegment constant_segment(Time begin, const Wrench& value) {
  return {begin, begin, {value}};
}

}  // namespace tactor
