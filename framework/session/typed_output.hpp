// An output of a node by name and type.
#pragma once

#include <string_view>

#include "framework/node/info.hpp"

namespace tactor {

/// The output `name` of the node; null if it has none, or one of another type.
inline const OutputInfo* typed_output(const NodeInfo& node, std::string_view name, const MessageType& type) {
  const OutputInfo* output = node.output(name);
  return output != nullptr && same_type(*output->type, type) ? output : nullptr;
}

}  // namespace tactor
