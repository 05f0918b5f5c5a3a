// CPU times of the steps of a run under the virtual clock, without what it takes to read the clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactor {

class VirtualClock;

/// ns, node by node, step by step.
using StepTimes = std::vector<std::vector<std::uint32_t>>;

/// The times of a run that measured them, of the first `nodes` nodes of its plan.
StepTimes step_times(const VirtualClock& engine, std::size_t nodes);

}  // namespace tactor
