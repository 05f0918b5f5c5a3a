// Lets a program fill an input of a graph.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "framework/graph/spec.hpp"

namespace tactor {

class Registry;

/// A node source.feed of messages of that type. Throws InputError where no library has it.
NodeSpec feed_node(const std::string& name, const MessageType& type, Registry& registry);

/// Puts a node source.feed before `input` (`device.target`), in the place of what fed it. Its edge has that queue, the
/// input's own where there is none. Session::feed(input) sends into it. Throws InputError where the graph has no such
/// input.
void add_feed(GraphSpec& graph, std::string_view input, Registry& registry, std::optional<Queue> queue = {});

}  // namespace tactor
