// Drives a live run to its end, as a session does.
#pragma once

#include <functional>
#include <thread>

#include "framework/engine/live/live_run.hpp"
#include "tests/framework/engine/engine_log.hpp"

namespace tactor::sample {

/// Runs to the end. `go_on` is asked ten times a second, `meanwhile` is called fifty times a second.
inline void drive(
    LiveRun& run, const std::function<bool(const LiveStatus&)>& go_on = [](const LiveStatus&) { return true; },
    const std::function<void()>& meanwhile = [] {}) {
  run.start();
  for (int look = 0; run.is_running(); ++look) {
    meanwhile();
    if (look % 5 == 4 && !go_on(run.look())) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  run.finish(meanwhile);
}

}  // namespace tactor::sample
