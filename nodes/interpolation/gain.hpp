// A displayed force times a factor that can be changed while the run goes on.
#pragma once

#include <optional>

#include "framework/core/messages.hpp"
#include "framework/node/info.hpp"

namespace tactor {

/// interpolation.gain: F(t) = g(t) F_in(t). A new factor is reached within `ramp`, g(t) = g_0 + (g_1 - g_0) (3 s^2 -
/// 2 s^3) with s = (t - t_0) / ramp, so that the force is continuous and changes by no more than 1.5 (g_1 - g_0) F_in /
/// ramp a second besides what F_in does. Between changes the coefficients of each segment are scaled, which is exact.
class Gain final : public Node {
 public:
  struct Params {
    double factor = 1;
    Duration ramp;
    double rate = 0;
  };
  Gain(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  /// The ramp begins with the next step.
  void tune(const Params& params) { params_ = params; }

  Input<ForceSegment> force;
  Output<ForceSegment> segment;

 private:
  struct Factor {
    double value = 0;
    double rate = 0;  // 1/s
  };
  [[nodiscard]] Factor factor(Time t) const;

  Params params_;
  Duration tick_;
  double from_, to_;  // the factor before and after the ramp
  Time begin_;        // of the ramp
  Duration ramp_;
  bool changing_ = false;
  std::optional<std::uint64_t> passed_;  // the sequence of the newest segment that went out scaled
};

}  // namespace tactor
