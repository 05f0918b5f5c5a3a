// A graph whose device is led by a page, in the place of the one it has.
#pragma once

#include <string>

#include "framework/graph/spec.hpp"

namespace tactor {

class Registry;

/// The device of a graph: its one actuator. Throws InputError where it has none or several.
const NodeSpec& device_of(const GraphSpec& graph);

/// Where the handle is when the graph's run begins: what its device shows first, or where that is hardware the tool's
/// pose in the scene.
Pose first_handle_pose(const GraphSpec& graph);

/// Puts a device.mouse in the place of the graph's device, with the same rate and limits, and a feed before its cursor.
/// It begins at `start`. What led the old device is not needed any more. Returns the device's name.
std::string lead_by_mouse(GraphSpec& graph, const Pose& start, Registry& registry);

/// Takes out the sinks that only judge a run afterwards: they keep all of it.
void take_out_sinks(GraphSpec& graph);

}  // namespace tactor
