// The forces of a contact that sliding lifts.
#pragma once

#include <algorithm>

namespace tactor {

/// A contact whose lift and friction are the slope of one convex function of the velocities: with u_n along the normal,
/// u_t across it, and s = max(0, |u_t| - creep friction N),
///   N = max(0, push - slope u_n + friction share slope s),   friction force = friction N where s > 0, else |u_t| /
///   creep.
/// So bodies part by `friction` of what they slip, as in MuJoCo's elliptic cone. Another lift is this one with another
/// push, as the s of the iteration before wants it.
struct LiftingContact {
  double push = 0;      ///< N, at zero velocity
  double slope = 0;     ///< N s/m
  double friction = 0;  ///< Coulomb coefficient
  double creep = 0;     ///< m/s per N
  double share = 1;     ///< change of u_n over that of |u_t| where the bodies' unknown velocities change alike

  /// What it does at some velocity.
  struct At {
    double normal = 0;   ///< N; 0: no force at all
    double slip = 0;     ///< m/s, s
    double stretch = 1;  ///< `slope` over what the normal force falls by with u_n
  };
  [[nodiscard]] At at(double normal_speed, double sliding_speed) const {
    At a;
    const double alone = push - slope * normal_speed;
    if (sliding_speed <= creep * friction * std::max(0.0, alone)) return {std::max(0.0, alone), 0, 1};
    a.stretch = 1 + friction * friction * share * slope * creep;
    a.normal = std::max(0.0, (alone + friction * share * slope * sliding_speed) / a.stretch);
    a.slip = sliding_speed - creep * friction * a.normal;
    return a;
  }
};

}  // namespace tactor
