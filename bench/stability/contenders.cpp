#include "bench/stability/stepper.hpp"

namespace tactor::bench {

std::vector<Contender> contenders() {
  const auto ode = [](OdeOptions options) {
    return [options](const Trial& trial, Duration period) { return make_ode(trial, period, options); };
  };
  return {{"tactor", make_tactor},
          {"ode", ode({})},
          {"ode_quick", ode({.quick = true})},
          {"ode_explicit", ode({.explicit_spring = true})},
          {"ode_substeps", ode({.substeps = true})}};
}

}  // namespace tactor::bench
