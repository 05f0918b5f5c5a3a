#include "app/run/step_times.hpp"

#include <algorithm>

#include "framework/engine/virtual_clock.hpp"

namespace tactor {

namespace {

/// ns that a step seems to take where it does nothing: the least between two readings of the clock.
std::uint32_t clock_cost_ns() {
  std::int64_t least = INT64_MAX;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t begin = thread_cpu_ns();
    least = std::min(least, thread_cpu_ns() - begin);
  }
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(least, 0, 10000));
}

}  // namespace

StepTimes step_times(const VirtualClock& engine, std::size_t nodes) {
  static const std::uint32_t reading = clock_cost_ns();
  StepTimes times(nodes);
  for (std::size_t n = 0; n < nodes; ++n) {
    times[n] = engine.node_figures(n).cpu_ns;
    for (std::uint32_t& step : times[n]) step -= std::min(step, reading);
  }
  return times;
}

}  // namespace tactor
