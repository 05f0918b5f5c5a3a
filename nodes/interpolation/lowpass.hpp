// A critically damped low-pass of second order on the held physics force.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/interpolation/force_state.hpp"

namespace tactor {

/// interpolation.lowpass: tau^2 F'' + 2 tau F' + F = F_t, with F_t the newest physics force. Between ticks the input is
/// constant, so with e = F - F_t the exact solution serves:
///   e(h) = (e + (F' + e / tau) h) exp(-h / tau),  F'(h) = (F' - (F' + e / tau) h / tau) exp(-h / tau).
/// A ramp is displayed 2 tau late.
class LowPass final : public Node {
 public:
  struct Params {
    Duration time_constant;
    double rate = 0;
  };
  LowPass(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;
  /// From the next step on.
  void tune(const Params& params) { next_tau_ = params.time_constant.seconds(); }

  Input<Forecast> forecast;
  Output<ForceSegment> segment;

 private:
  // Value and rate of the filter h seconds later; the curvature is not followed.
  [[nodiscard]] ForceState after(const ForceState& state, double h) const;

  double tau_, next_tau_;  // s
  Duration tick_;
  ForceState state_;
  Wrench target_;
  Time last_;
  bool running_ = false;
};

}  // namespace tactor
