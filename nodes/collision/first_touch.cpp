#include "nodes/collision/first_touch.hpp"

#include <algorithm>

namespace tactor {

namespace {
constexpr double tolerance = 1e-4;  // of the way
constexpr int most_looks = 64;
}  // namespace

std::optional<Nearest> look_ahead(const SignedDistance& other, StraightWay& on) {
  const double length = norm(on.way);
  if (!(length > 0) || on.looks++ >= most_looks) {
    on.share = 1;
    return {};
  }
  Nearest n = other.nearest(on.from + on.share * on.way, on.face);
  on.face = n.face;
  const double gap = n.distance - on.radius;
  if (gap <= tolerance * length && dot(n.gradient, on.way) < 0) {
    n.distance = dot(n.gradient, on.from - n.p);
    return n;
  }
  on.share += std::max(gap / length, tolerance);
  return {};
}

std::optional<Nearest> first_touch(const SignedDistance& other, StraightWay& on) {
  while (on.share < 1) {
    if (std::optional<Nearest> touch = look_ahead(other, on)) return touch;
  }
  return {};
}

}  // namespace tactor
