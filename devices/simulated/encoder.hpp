// What a device's encoders show of its motion: noise, steps of position, and a velocity estimated from them.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cstdint>
#include <optional>

#include "devices/simulated/motion.hpp"
#include "framework/core/time.hpp"
#include "framework/realtime/pose_filter.hpp"

namespace tactor {

struct EncoderParameters {
  double step = 0;        ///< m; 0: none
  double step_angle = 0;  ///< rad; 0: none
  VelocityParams velocity;
  double noise = 0;        ///< m, root of the mean square, of each coordinate; 0: none
  double noise_angle = 0;  ///< rad, of each coordinate of the rotation vector
  std::uint64_t seed = 0;  ///< of the noise
  double interval = 0;     ///< s, of ticks
};

/// Adds white Gaussian noise to each coordinate, then rounds it to the nearest multiple of a step; the rotation vector
/// likewise. The velocity is what PoseFilter makes of that, a step being noise of the variance step^2/12, or the true
/// one where there is neither step nor noise.
class Encoder {
 public:
  Encoder(const EncoderParameters& parameters, bool rotate);

  /// What is shown of `truth` at `now`; called once a tick.
  MotionState read(const MotionState& truth, Time now);
  /// PoseFilter::mixed_share(); none where the translation's encoder is exact.
  [[nodiscard]] std::optional<double> mixed_share() const;

 private:
  Vec3 noisy(const Vec3& value, double deviation);

  EncoderParameters parameters_;
  bool rotate_;
  boost::random::mt19937_64 engine_;
  boost::random::normal_distribution<double> normal_;
  std::optional<PoseFilter> filter_;  // where there are steps or noise
};

}  // namespace tactor
