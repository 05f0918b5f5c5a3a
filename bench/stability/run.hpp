// Runs one cell of a scene with one stepper.
#pragma once

#include "bench/stability/stepper.hpp"

namespace tactor::bench {

/// Query, one physics period, query, ... until the hand's path ends or a state is not finite.
Finding run_cell(const TrialScene& scene, const Cell& cell, const Contender& contender);

}  // namespace tactor::bench
