// The parameters of devices that estimate the velocity of their handle from positions.
#pragma once

#include <optional>
#include <string>

#include "framework/node/declare.hpp"
#include "framework/realtime/pose_filter.hpp"

namespace tactor {

/// Adds VelocityParams, from which the Params of N derive, to the declaration of device N.
template <class N>
void declare_velocity(Declare<N>& declaration) {
  using P = typename N::Params;
  const VelocityParams defaults;
  declaration
      .real("velocity_departure", static_cast<double P::*>(&P::velocity_departure),
            {.doc = "how far the handle departs from constant acceleration in 10 ms, for the filter that estimates its "
                    "velocity. Less is smoother and later",
             .unit = "m",
             .default_value = defaults.velocity_departure,
             .min = 0,
             .max = 1,
             .above_min = true})
      .real("velocity_departure_angle", static_cast<double P::*>(&P::velocity_departure_angle),
            {.doc = "the same for its rotation",
             .unit = "rad",
             .default_value = defaults.velocity_departure_angle,
             .min = 0,
             .max = 10,
             .above_min = true})
      .choice(
          "velocity_filter", static_cast<VelocityFilter P::*>(&P::velocity_filter),
          {{"several", VelocityFilter::several}, {"mixed", VelocityFilter::mixed}, {"one", VelocityFilter::one}},
          std::optional(defaults.velocity_filter),
          "several: models of the handle's motion run side by side, weighted by how well each predicts it; mixed: more "
          "models, added up so that a hand feels least of the encoder's steps; one: a single model that adapts, which "
          "is later if a hand trembles")
      .metric("device.velocity_mixed_share", "1",
              "share of the samples at which the filters of the translation were mixed; at the others the velocity is "
              "that of `several`, because samples come slower than at 250 Hz, or came unevenly in the last 0.1 s",
              Better::neither)
      .missing_where("the encoder is exact, or shows no second sample")
      .left_out_when([](const P& params, const MetricUse&) {
        return std::string(params.velocity_filter == VelocityFilter::mixed ? "" : "velocity_filter is not mixed");
      });
}

}  // namespace tactor
