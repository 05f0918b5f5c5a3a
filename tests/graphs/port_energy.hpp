// The energy that motors give at the handle, summed up from the commanded force and the true handle of a run.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "framework/core/messages.hpp"
#include "tests/support/shipped_graphs.hpp"

namespace tactor::test {

/// A run without a reference, and at each tick of its device what was commanded (N) and where the handle was (m).
struct Played {
  RunResult run;
  std::vector<Vec3> force, handle;
};

inline Played played(const std::filesystem::path& graph, const Over& over, std::vector<Listener> listeners = {}) {
  const Over recorded{"record=[device.truth, device.commanded]"};
  std::vector<Stamped<Wrench>> commanded;
  std::vector<Stamped<DeviceState>> truth;
  listeners.push_back(kept("device.commanded", commanded));
  listeners.push_back(kept("device.truth", truth));
  Played found{run(planned(graph, over + recorded), listeners, {.without_reference = true}), {}, {}};
  for (std::size_t i = 0; i < std::min(commanded.size(), truth.size()); ++i) {
    found.force.push_back(commanded[i].value.force);
    found.handle.push_back(truth[i].value.X_WD.p);
  }
  return found;
}

struct PortEnergy {
  double most = 0;     ///< J, the most net energy that the motors had given
  double allowed = 0;  ///< J, what a tick and a rounding of the encoder may bring
};

inline PortEnergy energy_of(const Played& found) {
  constexpr double encoder_step = 1e-5;  // m
  double given = 0, largest_force = 0, largest_tick = 0;
  PortEnergy energy;
  for (std::size_t i = 0; i < found.force.size(); ++i) {
    largest_force = std::max(largest_force, norm(found.force[i]));
    if (i + 1 == found.force.size()) break;
    const double in_tick = dot(found.force[i], found.handle[i + 1] - found.handle[i]);
    given += in_tick;
    energy.most = std::max(energy.most, given);
    largest_tick = std::max(largest_tick, std::abs(in_tick));
  }
  energy.allowed = largest_force * encoder_step + largest_tick;
  return energy;
}

}  // namespace tactor::test
