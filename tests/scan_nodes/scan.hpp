// A message type with everything that one may hold: records, an enumeration, arrays, times, and arrays that change
// size.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "framework/core/describe.hpp"

namespace tactor {

/// A point that a scanner saw.
struct ScanPoint {
  Vec3 p_SP;               ///< m
  std::uint16_t echo = 0;  ///< of how many
  float brightness = 0;    ///< W/m^2
};

/// A part of the scanner.
struct ScanHead {
  std::array<std::int8_t, 3> code{};
  Quat R_SH;
  SharedArray<float> warmth;  ///< K
};

enum class ScanQuality : std::uint8_t { good, dusty = 7, blind = 200 };

/// What one turn of the scanner shows.
struct Scan {
  std::uint8_t turn = 0;
  ScanQuality quality = ScanQuality::good;
  Time begin;
  SharedArray<ScanPoint> points;
  std::array<std::array<double, 2>, 3> bounds{};  ///< m
  std::array<ScanHead, 2> heads;
  std::int32_t last = 0;
};

template <>
inline const MessageType& message_type<ScanPoint>() {
  static const MessageType type = Describe<ScanPoint>("scan.Point", "", "A point that a scanner saw.")
                                      .field("p_SP", "m", &ScanPoint::p_SP, "Position, measured from the scanner.")
                                      .field("echo", "1", &ScanPoint::echo)
                                      .field("brightness", "W/m^2", &ScanPoint::brightness)
                                      .type();
  return type;
}

template <>
inline const MessageType& message_type<ScanHead>() {
  static const MessageType type = Describe<ScanHead>("scan.Head")
                                      .field("code", "1", &ScanHead::code)
                                      .field("R_SH", "1", &ScanHead::R_SH)
                                      .field("warmth", "K", &ScanHead::warmth)
                                      .type();
  return type;
}

template <>
inline const MessageType& message_type<Scan>() {
  static const MessageType type = Describe<Scan>("scan.Scan", "S", "One turn of a scanner.")
                                      .field("turn", "1", &Scan::turn)
                                      .choice("quality", &Scan::quality,
                                              {{"good", ScanQuality::good},
                                               {"dusty", ScanQuality::dusty, "Some points are missing."},
                                               {"blind", ScanQuality::blind}},
                                              "How far the turn can be trusted.")
                                      .field("begin", &Scan::begin)
                                      .field("points", &Scan::points)
                                      .field("bounds", "m", &Scan::bounds)
                                      .frame("W")
                                      .field("heads", &Scan::heads)
                                      .field("last", "1", &Scan::last)
                                      .type();
  return type;
}

/// Makes scans whose every value follows from their number.
class ScanMaker {
 public:
  ScanMaker(std::size_t arrays, std::size_t points) : points_(arrays, points), warmth_(2 * arrays, points) {}

  /// Scan number `n` with n % (capacity + 1) points.
  Scan make(std::int64_t n) {
    Scan scan;
    scan.turn = static_cast<std::uint8_t>(n);
    scan.quality = n % 3 == 0 ? ScanQuality::good : n % 3 == 1 ? ScanQuality::dusty : ScanQuality::blind;
    scan.begin = Time{n * 1'000'003};
    const std::size_t count = static_cast<std::size_t>(n) % (points_.capacity() + 1);
    scan.points =
        points_
            .make(count,
                  [n](std::span<ScanPoint> points) {
                    for (std::size_t i = 0; i < points.size(); ++i) {
                      const auto x = static_cast<double>(i) + 0.1 * static_cast<double>(n);
                      points[i] = {
                          {x, -1 / (x + 1), 1e300 * x}, static_cast<std::uint16_t>(i), static_cast<float>(x) / 3};
                    }
                  })
            .value();
    for (std::size_t i = 0; i < 6; ++i) scan.bounds[i / 2][i % 2] = static_cast<double>(n) / static_cast<double>(i + 1);
    for (std::size_t h = 0; h < 2; ++h) {
      ScanHead& head = scan.heads[h];
      head.code = {static_cast<std::int8_t>(-n), static_cast<std::int8_t>(h), 3};
      head.R_SH = {0.5, -0.5, 0.5, 0.5 * static_cast<double>(h)};
      head.warmth = warmth_
                        .make(h == 0 ? count : 1,
                              [n](std::span<float> warmth) {
                                for (std::size_t i = 0; i < warmth.size(); ++i) {
                                  warmth[i] = 300.0F + static_cast<float>(i) / static_cast<float>(n + 7);
                                }
                              })
                        .value();
    }
    scan.last = static_cast<std::int32_t>(-n);
    return scan;
  }

 private:
  ArrayPool<ScanPoint> points_;
  ArrayPool<float> warmth_;
};

/// True where two scans hold the same.
inline bool same_scan(const Scan& a, const Scan& b) {
  const auto same_point = [](const ScanPoint& p, const ScanPoint& q) {
    return p.p_SP == q.p_SP && p.echo == q.echo && p.brightness == q.brightness;
  };
  bool same = a.turn == b.turn && a.quality == b.quality && a.begin == b.begin && a.bounds == b.bounds &&
              a.last == b.last &&
              std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), same_point);
  for (std::size_t h = 0; h < 2; ++h) {
    const ScanHead &c = a.heads[h], &d = b.heads[h];
    same = same && c.code == d.code && c.R_SH == d.R_SH &&
           std::equal(c.warmth.begin(), c.warmth.end(), d.warmth.begin(), d.warmth.end());
  }
  return same;
}

}  // namespace tactor
