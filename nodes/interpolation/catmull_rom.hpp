// Uniform Catmull-Rom splines through physics forces and predicted ones.
#pragma once

#include <array>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

/// interpolation.catmull_rom: one segment for each forecast, one period long, between the middle two of four points one
/// period apart: C(u) = (2 P_1 + (P_2 - P_0) u + (2 P_0 - 5 P_1 + 4 P_2 - P_3) u^2 + (3 P_1 - P_0 - 3 P_2 + P_3) u^3)
/// / 2. Source: Catmull and Rom, "A class of local interpolating splines", Computer Aided Geometric Design (1974)
/// 317-326.
class CatmullRom final : public Node {
 public:
  enum class Start { current, predicted };
  struct Params {
    Start start = Start::predicted;
  };
  CatmullRom(const Params& params, const NodeContext&) : start_(params.start) {}
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 private:
  Start start_;
  Wrench before_;  // F_{t-1}
  bool any_ = false;
};

}  // namespace tactor
