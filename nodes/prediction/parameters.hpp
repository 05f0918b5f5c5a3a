// Parameters and ports that every predictor declares alike.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/period_parameters.hpp"
#include "nodes/prediction/sample_gate.hpp"

namespace tactor {

/// The parameters of a predictor of one physics period ahead.
struct PredictorParams : PeriodOptions, ForceLimits {};

/// Adds the input `force`, the output `forecast`, the device's limits and the period estimate.
template <class N>
Declare<N>& declare_predictor(Declare<N>& node) {
  using P = typename N::Params;
  node.realtime_safe()
      .input(
          "force", &N::force,
          {.doc = "the physics force on the device", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 64}})
      .output("forecast", &N::forecast, "the force and what is expected one physics period later")
      .real("force_max", static_cast<double P::*>(&P::force_max),
            {.doc = "current and predicted force are shortened to the device's largest force",
             .unit = "N",
             .default_value = 8.0,
             .min = 0,
             .above_min = true})
      .real("torque_max", static_cast<double P::*>(&P::torque_max),
            {.doc = "current and predicted torque are shortened to the device's largest torque",
             .unit = "N m",
             .default_value = 0.3,
             .min = 0,
             .above_min = true});
  return declare_period(node);
}

}  // namespace tactor
