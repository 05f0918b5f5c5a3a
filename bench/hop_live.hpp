// Two light nodes in the live engine and the plan that connects them.
#pragma once

#include "bench/hop_meter.hpp"
#include "framework/core/scheduling.hpp"

namespace tactor::bench {

/// Sends messages from one node to another for `duration` at 1 kHz. Both are in the pool, of `workers` threads under
/// `threads`; or the sender has a thread of its own under the same settings, where it is `detached`. Throws RunError
/// where the run fails.
void hop_by_live_run(bool detached, int workers, const ThreadSettings& threads, Duration duration, HopMeter& meter);

}  // namespace tactor::bench
