#include "bench/stability/stepper.hpp"

namespace tactor::bench {

std::vector<Contender> contenders() {
  const auto ode = [](OdeOptions options) {
    return [options](const Trial& trial, Duration period) { return make_ode(trial, period, options); };
  };
  const auto ours = [](bool as_made) {
    return [as_made](const Trial& trial, Duration period) { return make_tactor(trial, period, as_made); };
  };
  return {{"tactor", ours(false)},
          {"tactor_as_made", ours(true)},
          {"ode", ode({})},
          {"ode_quick", ode({.quick = true})},
          {"ode_explicit", ode({.explicit_spring = true})},
          {"ode_substeps", ode({.substeps = true})}};
}

}  // namespace tactor::bench
