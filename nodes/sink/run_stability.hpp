// Whether a run was stable, from what its device showed and displayed and where its tool was.
#pragma once

#include <optional>
#include <span>

#include "framework/core/messages.hpp"
#include "framework/core/stability.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// Where the handle was at a tick.
struct HandleSample {
  Time valid;
  Pose X_WD;
};

/// Where the tool was, and how fast.
struct ToolSample {
  Time valid;
  Vec3 p_WT;
  Vec3 v_WT;
};

/// What is known of a run. All samples in the order of `valid`.
struct RunSignals {
  std::span<const Stamped<Wrench>> commanded;  ///< on the handle about its origin, each until the next
  std::span<const HandleSample> handle;
  std::span<const ToolSample> tool;
  double mass = 0;  ///< kg, of the tool
  Vec3 gravity_W;   ///< m/s^2
  bool torque = true;
};

/// The finding; `rest` is the time at the end over which the tool is to be at rest, zero: nothing is asked of it.
/// Energy is counted where hand and device meet: given is minus the commanded wrench times the way of the handle, so
/// that `generated_J` is the most that the hand has got beyond what it had given and what the tool's weight gave.
/// `peak_energy_J` is the most that the tool had at a time in kinetic energy and, where it was above its first
/// position, in height. Absent where there are neither two samples of the handle nor two of the tool.
std::optional<StabilityFinding> run_stability(const RunSignals& signals, Duration rest, double peak_to_peak_max);

}  // namespace tactor
