// What holds between two stamped samples: values on the straight line, poses also about the shorter turn.
#pragma once

#include <cstddef>
#include <functional>

#include "framework/core/check.hpp"
#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// a + share (b - a).
template <class T>
T between(const T& a, const T& b, double share) {
  return a + share * (b - a);
}
/// Steady motion along the line and about the shorter turn.
inline Pose between(const Pose& a, const Pose& b, double share) {
  const Vec3 turn = to_rotation_vector(b.R * inverse(a.R));
  return {between(a.p, b.p, share), from_rotation_vector(share * turn) * a.R};
}

/// The share of the way from a to b, which is later than a, that has gone by at t.
inline double share_between(Time a, Time b, Time t) {
  return (t - a).seconds() / (b - a).seconds();
}

/// The value at `t` between the samples; the first before, the last after them. `time_of` and `value_of` name a
/// sample's time and value, as members or functions. `cursor` is a sample at or before t, and moves on; start with 0
/// and never decreasing times. Needs samples, in the order of their times.
template <class Samples, class TimeOf, class ValueOf>
auto value_between(const Samples& samples, Time t, std::size_t& cursor, TimeOf time_of, ValueOf value_of) {
  TACTOR_ASSERT(!samples.empty());
  while (cursor + 1 < samples.size() && std::invoke(time_of, samples[cursor + 1]) <= t) ++cursor;
  const auto& a = samples[cursor];
  auto value = std::invoke(value_of, a);
  if (t <= std::invoke(time_of, a) || cursor + 1 == samples.size()) return value;
  const auto& b = samples[cursor + 1];
  return between(value, std::invoke(value_of, b), share_between(std::invoke(time_of, a), std::invoke(time_of, b), t));
}

}  // namespace tactor
