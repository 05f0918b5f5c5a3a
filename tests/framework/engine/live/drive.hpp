// Drives a live run to its end, as a session does.
#pragma once

#include <functional>
#include <thread>

#include "framework/engine/live/live_engine.hpp"
#include "tests/framework/engine/engine_log.hpp"

namespace tactor::sample {

/// Runs to the end. `go_on` is asked ten times a second, `meanwhile` is called fifty times a second.
inline void drive(
    Engine& run, const std::function<bool(const EngineStatus&)>& go_on = [](const EngineStatus&) { return true; },
    const std::function<void()>& meanwhile = [] {}) {
  run.start();
  for (int look = 0; run.is_running(); ++look) {
    meanwhile();
    if (look % 5 == 4 && !go_on(run.status())) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  run.finish({.read = meanwhile});
}

}  // namespace tactor::sample
