// Where a point or a ball that moves straight on first touches a body.
#pragma once

#include <optional>

#include "nodes/collision/signed_distance.hpp"

namespace tactor {

/// The way of a point, or of a ball's centre, in the frame of the body that it may touch.
struct StraightWay {
  Vec3 from;               ///< m
  Vec3 way;                ///< m, to the end
  double radius = 0;       ///< m, of the ball
  double share = 0;        ///< of the way, up to which nothing is touched
  std::int32_t face = -1;  ///< of the last nearest point
  int looks = 0;
};

/// Goes on along the way by as much as is surely free, since a distance changes by no more than the way moved, and
/// returns where the ball touches if it does there: the tangent plane of the surface, as Nearest of the point `from`,
/// whose distance to that plane is positive. Else `share` has grown; from 1 on nothing is touched. A ball that comes
/// nearer than a ten-thousandth of the way touches. One that has not arrived after 64 looks, as on a way all but along
/// the surface, is given up as not touching.
std::optional<Nearest> look_ahead(const SignedDistance& other, StraightWay& on);

/// The same to the end: where the ball touches first, or nothing.
std::optional<Nearest> first_touch(const SignedDistance& other, StraightWay& on);

}  // namespace tactor
