#include "bench/stability/run.hpp"

#include <algorithm>
#include <chrono>

#include "bench/stability/judge.hpp"
#include "framework/core/check.hpp"

namespace tactor::bench {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

Reached first_state(const Trial& trial) {
  Reached state{.t = {}, .device = trial.hand.at({}, {}), .bodies = {}};
  for (const std::size_t i : trial.scene.moving()) {
    state.bodies.X_WB[static_cast<std::size_t>(state.bodies.count++)] = trial.scene.bodies[i].X_WB;
  }
  return state;
}

}  // namespace

Finding run_cell(const TrialScene& scene, const Cell& cell, const Contender& contender) {
  const Trial trial = scene.make(cell);
  const Duration period = Duration::from_rate(cell.rate);
  const auto steps = static_cast<std::int64_t>(std::llround(trial.hand.end() * cell.rate));
  const std::unique_ptr<Stepper> stepper = contender.make(trial, period);
  Judge judge(trial);
  Finding finding;
  ContactSet set;
  Reached at = first_state(trial);
  std::vector<Reached> reached;
  bool finite = true;
  for (std::int64_t i = 1; i <= steps && finite; ++i) {
    const Clock::time_point query = Clock::now();
    set.bodies = at.bodies;
    trial.query(at.bodies, set);
    const Clock::time_point step = Clock::now();
    finding.left_out = std::max(finding.left_out, set.truncated);
    finding.query_s += std::chrono::duration<double>(step - query).count();
    if (i == 1) {
      judge.begin(set);
      judge.see(at);
    }
    reached.clear();
    const Time until{period.ns * i};
    try {
      stepper->advance(set, until, reached);
    } catch (const RunError& e) {
      finding.why = e.what();
      finding.verdict = StabilityVerdict::not_finite;
      return finding;
    }
    finding.step_s += seconds_since(step);
    finding.simulated_s = until.seconds();
    for (const Reached& state : reached) finite = judge.see(state) && finite;
    at = reached.back();
  }
  judge.finish(finding);
  stepper->report(finding);
  return finding;
}

}  // namespace tactor::bench
