// Whether the port of a device gave more energy than a rounding and a tick can bring: the strict form of "stable".
#pragma once

#include <optional>

#include "nodes/sink/run_stability.hpp"

namespace tactor {

/// What a port gave, and what it may give without having been active.
struct PortPassivity {
  double generated_J = 0;  ///< the most net energy that the motors had given at a time, beyond the weight's
  double allowed_J = 0;    ///< max |F| D + max |F . dx| over the ticks
  [[nodiscard]] bool passive() const { return generated_J <= allowed_J; }
};

/// The net energy is the sum of F(n) . (x(n+1) - x(n)), F the wrench commanded at sample n and held; rotation likewise,
/// by the rotation vector of R(n+1) R(n)^T. The tool's weight w, which the hand has lifted or which lies in the scene,
/// gives w . (x(n+1) - x(n)) while something is commanded, which is taken off. Allowed is what a measurement with steps
/// D (m; `step_angle` in rad) misses at the largest force and torque, and what one tick gives at most: a renderer that
/// sees the handle once a tick cannot do better. Only the handle and the commands of `signals` are looked at. Absent
/// where there are fewer than two samples of the handle. Not finite signals make it NaN, which is not passive.
std::optional<PortPassivity> port_passivity(const RunSignals& signals, double step, double step_angle);

}  // namespace tactor
