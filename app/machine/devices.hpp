// The verbs `devices` and `device`: what is attached, a try of one device, and its calibration.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/spec.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

/// A line for each attached device that a type of the registry recognises, with the type in front. What keeps devices
/// from being recognised is told as notes.
std::string device_list(const Registry& registry);

/// The node of hardware that `name` says, or the only one of the graph. Throws InputError where there is none, or
/// several and no name.
const NodeSpec& hardware_node(const GraphSpec& graph, const std::string& name);

/// What a try of a device does.
struct DeviceTrial {
  double force = 1;    ///< N, the largest
  double seconds = 2;  ///< of the position before, and of each ramp
  bool yes = false;    ///< do not ask
};

/// Shows the device's position, and on confirmation gives it small forces, one direction of the scene after the other,
/// through its safety gate. Ends at zero force when `interrupted` is set. Returns the exit code. Throws RunError where
/// the device cannot be reached.
int try_device(const GraphSpec& graph, const NodeSpec& device, const DeviceTrial& trial, Registry& registry,
               const std::atomic<int>& interrupted);

/// Calibrates it, as its node type does that. Throws InputError where the type has no calibration.
void calibrate_device(const NodeSpec& device, bool yes, const std::atomic<int>& interrupted);

}  // namespace tactor
