// Streams of forces that predictors are known to fail on.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/force_stream.hpp"

namespace tactor::test {

inline constexpr int hostile_kinds = 14;

/// Sample t of the stream `kind`; kind 0 is harmless.
inline Wrench hostile(int kind, int t, Dice& draw) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const double s = 0.2 * t;
  const Wrench calm{{std::sin(s), 2, 0}, {0, 0.1 * std::cos(s), 0}};
  const bool now = draw(0, 1) < 0.02;
  switch (kind) {
    case 0:
      return calm;
    case 1:
      return now ? Wrench{{std::nan(""), 0, 0}, {}} : calm;
    case 2:
      return now ? Wrench{{0, inf, 0}, {-inf, 0, 0}} : calm;
    case 3:  // impulses of 20 N
      return now ? Wrench{{20, 0, 0}, {2, 0, 0}} : Wrench{};
    case 4:  // random steps from bound to bound
      return {{draw(-1, 1) > 0 ? 8.0 : -8.0, 0, 0}, {0.5, 0, 0}};
    case 5:  // squares that overflow
      return now ? Wrench{{1e200, -1e200, 0}, {1e120, 0, 0}} : calm;
    case 6:  // denormals
      return {{4.9e-324, 1e-310, 0}, {1e-170, 0, 0}};
    case 7:  // exponential growth
      return {{std::min(8.0, 1e-3 * std::exp(0.3 * (t % 60))), 0, 0}, {}};
    case 8:  // 260 orders of magnitude
      return {draw.normal_vector(std::exp(draw(-300, 300))), draw.normal_vector(1e-200)};
    case 9:  // saturation
      return {{std::clamp(20 * std::sin(s), -8.0, 8.0), 0, 0}, {}};
    case 10:  // an exact wave: two coefficients say all
      return {{3 * std::sin(s), 3 * std::cos(s), 0}, {0, 0, 0.1 * std::sin(s)}};
    case 11:  // alternating
      return {{t % 2 == 0 ? 1.0 : -1.0, 0, 0}, {0, t % 2 == 0 ? 0.1 : -0.1, 0}};
    case 12:  // constant
      return {{5, -3, 1}, {0.1, 0, 0}};
    default:  // contact that begins and ends
      return t / 15 % 2 == 0 ? Wrench{} : Wrench{{6, 0.1 * (t % 15), 0}, {0, 0.2, 0}};
  }
}

}  // namespace tactor::test
