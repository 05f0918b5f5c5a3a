#include "app/run/timed_run.hpp"

#include <algorithm>
#include <cstdint>

#include "framework/engine/virtual_clock.hpp"

namespace tactor {

namespace {

class InterruptWatch final : public RunObserver {
 public:
  explicit InterruptWatch(const std::function<bool()>& interrupted) : interrupted_(interrupted) {}
  bool on_progress(Time) override {
    if (interrupted_()) throw Interrupted();
    return true;
  }

 private:
  const std::function<bool()>& interrupted_;
};

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

void run_to_end(VirtualClock& engine, const std::function<bool()>& interrupted) {
  InterruptWatch watch(interrupted);
  engine.run(watch);
}

std::vector<double> node_costs(const VirtualClock& engine, std::size_t nodes) {
  static const std::uint32_t reading = clock_cost_ns();
  const double seconds = engine.now().seconds();
  std::vector<double> costs(nodes, 0.0);
  for (std::size_t n = 0; n < nodes; ++n) {
    const NodeStatistics& metrics = engine.node_statistics(n);
    const double ns = static_cast<double>(metrics.cpu_total.ns) - reading * static_cast<double>(metrics.cpu.count());
    costs[n] = 1e-3 * std::max(ns, 0.0) / seconds;
  }
  return costs;
}

}  // namespace tactor
