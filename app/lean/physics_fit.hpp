// Whether a step of physics fits a tick of the haptic loop, measured: where it does, nothing need be predicted.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

/// What a step of one node of physics takes.
struct PhysicsNode {
  std::string node;
  double mean_us = 0;  ///< CPU time
  double p99_us = 0;   ///< CPU time that 99 of 100 steps stay below
};

/// What a step of physics takes when it is made in every tick of the haptic loop.
struct PhysicsFit {
  std::vector<PhysicsNode> nodes;  ///< of the roles collision and dynamics
  double tick_us = 0;
  double seconds = 0;        ///< simulated, of the run that was measured
  std::string declared;      ///< the nodes of physics to which the graph gives a cost, or empty
  bool foreign = false;      ///< the bodies are moved by an engine with a law of its own
  std::string not_measured;  ///< why nothing was measured, or empty

  [[nodiscard]] double mean_us() const;
  /// The sum over the nodes: no less than what 99 of 100 steps of all of them take together.
  [[nodiscard]] double p99_us() const;
  /// Half a tick is left to the other nodes and to the machine.
  [[nodiscard]] bool fits() const { return not_measured.empty() && p99_us() <= tick_us / 2; }
};

/// Runs the graph under the virtual clock with a step of physics in every tick, for all of its duration, but for no
/// longer than about 2 s of real time and 10 s of simulated time. None where no node moves bodies. Where the run fails,
/// `not_measured` says why. Throws Interrupted where the user ends it.
std::optional<PhysicsFit> measure_physics_fit(const Plan& plan, const std::function<bool()>& interrupted);

/// What people are told, line by line: whether it fits, by how much, and what follows.
std::string text_of(const PhysicsFit& fit, const std::string& indent = {});
nlohmann::ordered_json to_json(const PhysicsFit& fit);

}  // namespace tactor
