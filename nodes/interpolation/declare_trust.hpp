// The parameters that say how far a rollout trusts the results of physics.
#pragma once

#include <string>

#include "framework/node/declare.hpp"
#include "nodes/interpolation/rollout_trust.hpp"

namespace tactor {

/// Adds `trust_time` and `trust_time_max`. `beyond`: what happens to a result that is older.
template <class N>
void declare_trust_time(Declare<N>& node, const std::string& beyond) {
  using Params = typename N::Params;
  node.template real<Duration>("trust_time", &Params::trust_time,
                               {.doc = "age of a physics result beyond which " + beyond +
                                       ". Three times the longest of the last 16 intervals between results counts "
                                       "instead if that is more",
                                .unit = "s",
                                .default_value = 0.25,
                                .min = 0,
                                .max = 10})
      .template real<Duration>("trust_time_max", &Params::trust_time_max,
                               {.doc = "upper limit of trust_time when results are slow; longer intervals do not count",
                                .unit = "s",
                                .default_value = 1,
                                .min = 0,
                                .max = 10});
}

/// The same and `trust_distance`. `distance`: what the distance means.
template <class N>
void declare_trust(Declare<N>& node, const std::string& beyond, const std::string& distance) {
  using Params = typename N::Params;
  declare_trust_time(node, beyond);
  node.template real<double>("trust_distance", &Params::trust_distance,
                             {.doc = distance, .unit = "m", .default_value = 0.02, .min = 0, .max = 10});
}

/// Adds `disagreement` and `patience`. `goes`: what goes to where physics has it.
template <class N>
void declare_disagreement(Declare<N>& node, const std::string& goes) {
  using Params = typename N::Params;
  node.template real<double>("disagreement", &Params::disagreement,
                             {.doc = "physics and the rollout disagree if their tools are farther apart than this",
                              .unit = "m",
                              .default_value = 5e-4,
                              .min = 0,
                              .max = 1})
      .template real<Duration>(
          "patience", &Params::patience,
          {.doc = "how long they may disagree in one direction before the " + goes + " goes to where physics has it",
           .unit = "s",
           .default_value = 1,
           .min = 0,
           .max = 10});
}

}  // namespace tactor
