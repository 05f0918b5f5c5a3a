// Time and Duration: strong types over whole nanoseconds, so that event order never depends on rounding.
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

namespace tactor {

/// A span of time in whole nanoseconds.
struct Duration {
  std::int64_t ns = 0;

  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }
  [[nodiscard]] constexpr double milliseconds() const { return static_cast<double>(ns) * 1e-6; }
  [[nodiscard]] constexpr double microseconds() const { return static_cast<double>(ns) * 1e-3; }

  /// The nearest whole nanosecond to `s` seconds.
  [[nodiscard]] static Duration from_seconds(double s) { return {static_cast<std::int64_t>(std::llround(s * 1e9))}; }
  /// The period of `hz` cycles a second.
  [[nodiscard]] static Duration from_rate(double hz) { return from_seconds(1.0 / hz); }

  constexpr auto operator<=>(const Duration&) const = default;
  constexpr Duration& operator+=(Duration d) {
    ns += d.ns;
    return *this;
  }
};

constexpr Duration operator+(Duration a, Duration b) {
  return {a.ns + b.ns};
}
constexpr Duration operator-(Duration a, Duration b) {
  return {a.ns - b.ns};
}
constexpr Duration operator*(Duration a, std::int64_t n) {
  return {a.ns * n};
}

/// A point in time: nanoseconds since the start of the run.
struct Time {
  std::int64_t ns = 0;

  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }
  [[nodiscard]] static Time from_seconds(double s) { return {static_cast<std::int64_t>(std::llround(s * 1e9))}; }

  constexpr auto operator<=>(const Time&) const = default;
};

constexpr Time operator+(Time t, Duration d) {
  return {t.ns + d.ns};
}
constexpr Time operator-(Time t, Duration d) {
  return {t.ns - d.ns};
}
constexpr Duration operator-(Time a, Time b) {
  return {a.ns - b.ns};
}

}  // namespace tactor
