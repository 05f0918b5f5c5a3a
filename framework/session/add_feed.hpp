// Lets a program fill an input of a graph.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "framework/graph/spec.hpp"

namespace tactor {

class Registry;

/// A node source.feed for messages of that type. Throws InputError if no library has the type.
NodeSpec feed_node(const std::string& name, const MessageType& type, Registry& registry);

/// Puts a node source.feed before `input` (`device.target`), replacing the edge that fed it. The new edge takes over
/// its queue, or the input's own if there was none. Session::feed(input) sends into it. Throws InputError if the graph
/// has no such input, or the queue is too large (queue_bounds.hpp).
void add_feed(GraphSpec& graph, std::string_view input, Registry& registry, std::optional<Queue> queue = {});

}  // namespace tactor
