// No interpolation: each physics force is displayed as it is until the next one comes.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

/// interpolation.none: F(t) = F_t, the newest physics force, in steps.
class NoInterpolation final : public Node {
 public:
  struct Params {};
  NoInterpolation(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Forecast> forecast;
  Output<ForceSegment> segment;
};

}  // namespace tactor
