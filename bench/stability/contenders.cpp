#include "bench/stability/stepper.hpp"

namespace tactor::bench {

std::vector<Contender> contenders() {
  const auto ode = [](OdeOptions options) {
    return [options](const Trial& trial, Duration period) { return make_ode(trial, period, options); };
  };
  const auto ours = [](bool dissipate) {
    return [dissipate](const Trial& trial, Duration period) { return make_tactor(trial, period, dissipate); };
  };
  return {{"tactor", ours(false)},
          {"tactor_dissipate", ours(true)},
          {"ode", ode({})},
          {"ode_quick", ode({.quick = true})},
          {"ode_explicit", ode({.explicit_spring = true})},
          {"ode_substeps", ode({.substeps = true})}};
}

}  // namespace tactor::bench
