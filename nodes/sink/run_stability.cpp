#include "nodes/sink/run_stability.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/core/between_samples.hpp"

namespace tactor {

namespace {

/// J, what the hand gave while the handle went from `from` to `to` against a wrench.
double given(const Wrench& on_handle, const Pose& from, const Pose& to, bool torque) {
  double work = -dot(on_handle.force, to.p - from.p);
  if (torque) work -= dot(on_handle.torque, to_rotation_vector(to.R * inverse(from.R)));
  return work;
}

/// The last command at or before t, nothing before the first. `cursor` counts the commands up to t.
Wrench command_at(std::span<const Stamped<Wrench>> commanded, Time t, std::size_t& cursor) {
  while (cursor < commanded.size() && commanded[cursor].stamp.valid <= t) ++cursor;
  return cursor == 0 ? Wrench{} : commanded[cursor - 1].value;
}

/// J, kinetic energy and height above the first sample, the most; stops at a sample that is not finite. Height below it
/// counts nothing: a tool that goes down has its motion still.
double peak_energy(const RunSignals& signals) {
  double peak = 0;
  for (const ToolSample& s : signals.tool) {
    const double height = std::max(0.0, -dot(signals.gravity_W, s.p_WT - signals.tool.front().p_WT));
    const double energy = signals.mass * (0.5 * dot(s.v_WT, s.v_WT) + height);
    if (!std::isfinite(energy)) break;
    peak = std::max(peak, energy);
  }
  return peak;
}

bool tool_is_finite(std::span<const ToolSample> tool) {
  return std::all_of(tool.begin(), tool.end(),
                     [](const ToolSample& s) { return is_finite(s.p_WT) && is_finite(s.v_WT); });
}

}  // namespace

std::optional<StabilityFinding> run_stability(const RunSignals& signals, Duration rest, double peak_to_peak_max) {
  const bool by_handle = signals.handle.size() >= 2;
  if (!by_handle && signals.tool.size() < 2) return std::nullopt;
  const std::size_t count = by_handle ? signals.handle.size() : signals.tool.size();
  const auto time = [&](std::size_t i) { return by_handle ? signals.handle[i].valid : signals.tool[i].valid; };
  std::vector<StabilityRest> rests;
  const double end = time(count - 1).seconds();
  if (rest.ns > 0) rests.push_back({.begin = end - rest.seconds(), .end = end, .p_WT = {}});
  StabilityJudge judge({.peak_to_peak_max = peak_to_peak_max}, rests);

  std::size_t tool = 0, command = 0;
  Wrench wrench;
  Vec3 last;
  for (std::size_t i = 0; i < count; ++i) {
    const Time t = time(i);
    StabilitySample sample{.t = t.seconds()};
    sample.p_WT = signals.tool.empty() ? signals.handle[i].X_WD.p
                                       : value_between(signals.tool, t, tool, &ToolSample::valid, &ToolSample::p_WT);
    sample.stored = -signals.mass * dot(signals.gravity_W, sample.p_WT);
    if (i > 0) sample.released = std::max(0.0, signals.mass * dot(signals.gravity_W, sample.p_WT - last));
    if (by_handle && i > 0) {
      sample.given = given(wrench, signals.handle[i - 1].X_WD, signals.handle[i].X_WD, signals.torque);
    }
    wrench = command_at(signals.commanded, t, command);
    sample.finite = is_finite(wrench);
    last = sample.p_WT;
    if (!judge.see(sample)) break;
  }
  if (!tool_is_finite(signals.tool)) judge.see({.t = end, .finite = false});
  StabilityFinding finding = judge.finish();
  finding.peak_energy_J = peak_energy(signals);
  return finding;
}

}  // namespace tactor
