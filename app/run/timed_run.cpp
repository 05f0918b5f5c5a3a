#include "app/run/timed_run.hpp"

#include <algorithm>
#include <cstdint>

#include "framework/core/clock.hpp"
#include "framework/session/session.hpp"

namespace tactor {

namespace {

/// ns that a step seems to take where it does nothing: the least between two readings of the clock.
std::uint32_t clock_cost_ns() {
  std::int64_t least = INT64_MAX;
  for (int i = 0; i < 1000; ++i) {
    const Duration begin = clock_time(CLOCK_THREAD_CPUTIME_ID);
    least = std::min(least, (clock_time(CLOCK_THREAD_CPUTIME_ID) - begin).ns);
  }
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(least, 0, 10000));
}

}  // namespace

void run_to_end(Session& session, const std::function<bool()>& interrupted) {
  constexpr Duration period{10'000'000};
  session.run(period, [&interrupted] {
    if (interrupted()) throw Interrupted();
  });
}

std::vector<double> node_costs(Session& session) {
  static const std::uint32_t reading = clock_cost_ns();
  const double seconds = session.now().seconds();
  std::vector<double> costs(session.plan().nodes.size(), 0.0);
  for (std::size_t n = 0; n < costs.size(); ++n) {
    const NodeStatistics metrics = session.node_statistics(n);
    const double ns = static_cast<double>(metrics.cpu_total.ns) - reading * static_cast<double>(metrics.cpu.count());
    costs[n] = 1e-3 * std::max(ns, 0.0) / seconds;
  }
  return costs;
}

}  // namespace tactor
