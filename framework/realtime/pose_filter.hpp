// The velocity of a handle, of both its translation and its rotation, from the poses that its encoders show.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"
#include "framework/realtime/mixed_filter.hpp"
#include "framework/realtime/motion_filter.hpp"

namespace tactor {

/// How the velocity of a handle is estimated.
enum class VelocityFilter {
  mixed,    ///< MixedFilter; MotionFilter where samples come too slowly for it
  several,  ///< MotionFilter
  one,      ///< MotionFilter of one model that adapts
};

/// The parameters of the velocity that all devices have which estimate it; `declare_velocity` declares them.
struct VelocityParams {
  double velocity_departure = 2e-6;        ///< m, in 10 ms, see MotionFilter
  double velocity_departure_angle = 2e-5;  ///< rad, in 10 ms
  VelocityFilter velocity_filter = VelocityFilter::mixed;
};

/// Estimates the velocity of a pose. The rotation is filtered as small turns about its estimate.
class PoseFilter {
 public:
  /// `noise` and `noise_angle`: standard deviations of a coordinate of a sample, m and rad; `interval`: that of most
  /// samples, s. The filter of the rotation is made only where the pose rotates.
  PoseFilter(const VelocityParams& params, double noise, double noise_angle, double interval, bool rotate);

  /// Takes in the pose at `now`; one that is not later than the last, or not finite, is left out. After 1 s without any
  /// it starts anew.
  void take(const Pose& X_WD, Time now);
  /// m/s and rad/s in W; the angular one zero where nothing rotates.
  [[nodiscard]] Twist velocity() const;
  /// The share of the samples taken in at which the translation's velocity was that of a MixedFilter that mixes; none
  /// before the first, or where `mixed` is not asked for.
  [[nodiscard]] std::optional<double> mixed_share() const;

 private:
  using Filter = std::variant<std::monostate, MixedFilter, MotionFilter>;

  bool mixed_asked_;
  Filter translation_, rotation_;
  std::uint64_t samples_ = 0, mixed_ = 0;
  bool started_ = false;
  Time last_;
  Quat R_;  // the estimate
};

}  // namespace tactor
