// source.trajectory: where the hand wants to be, along way-points, with the tremor of a hand.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"
#include "nodes/source/path.hpp"
#include "nodes/source/tremor.hpp"

namespace tactor {

/// Sends the target of the hand at a rate. Pose and velocity are analytic functions of the time and the seed: the same
/// at every rate. Throws InputError where the way-points are given twice, not at all, or do not make a path.
class TrajectorySource final : public Node {
 public:
  struct Params {
    double rate = 0;  ///< Hz
    Table points;     ///< t [s], x y z [m], rx ry rz [rad]
    std::filesystem::path file;
    PathKind interpolation = PathKind::minimum_jerk;
    Duration repeat_after;        ///< 0: never
    Duration halt;                ///< 0: never
    double tremor_amplitude = 0;  ///< m rms on each axis
    double tremor_low = 0;        ///< Hz
    double tremor_high = 0;       ///< Hz
    std::int32_t tremor_components = 0;
  };

  TrajectorySource(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  /// The target at `t` (s).
  [[nodiscard]] Target at(double t) const;

  [[nodiscard]] const Path& path() const { return path_; }

  Output<Target> target;

 private:
  bool rotates_;
  std::optional<double> halt_;  // s
  double repeat_after_;         // s, 0: never
  Path path_;
  Tremor tremor_;
};

}  // namespace tactor
