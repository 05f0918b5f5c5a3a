// Two bare CAF actors and a timer: what a message costs without this project's engine.
#pragma once

#include <string>

#include "bench/hop_meter.hpp"
#include "framework/core/scheduling.hpp"

namespace tactor::bench {

/// The schedulers of CAF that are measured.
enum class CafScheduler {
  stealing,  ///< work stealing without polling sleeps: aggressive-poll-attempts 1, moderate 0, relaxed-sleep 100 ms
  sharing,   ///< one shared queue
  defaults,  ///< work stealing as CAF comes, its number of workers included
};

/// Sends messages from one actor to another for `duration`, at 1 kHz by absolute deadlines of a timer thread under
/// `timer`, whose tick is a message to the sender.
///
/// `workers` threads of CAF's scheduler run under `threads`, and so does the sender's own where it is `detached`.
void hop_by_caf(CafScheduler scheduler, bool detached, int workers, const ThreadSettings& threads,
                const ThreadSettings& timer, Duration duration, HopMeter& meter);

}  // namespace tactor::bench
