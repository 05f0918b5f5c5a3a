// Messages of the bridge as packed bytes: little-endian, at places that docs/howto/bridge.md lists.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "app/bridge/bridge_messages.hpp"

namespace tactor {

/// The first number of a packed message.
enum class BridgeKind : std::uint32_t { step = 1, result = 2, error = 3, next = 4 };

std::string to_bytes(const BridgeStep& step);
std::string to_bytes(const BridgeResult& result);
std::string to_bytes(const BridgeError& error);

/// The message of a client. Throws BridgeRefusal.
std::variant<BridgeNext, BridgeResult> read_client_bytes(std::string_view bytes);
/// Throws BridgeRefusal where the bytes are no step.
BridgeStep read_step_bytes(std::string_view bytes);

/// The places of all fields as JSON: {"step": {"kind": 1, "bytes": 312, "fields": [{"name": "id", "type": "u64",
/// "count": 1, "offset": 8}, ...]}, "result": ..., "contact": ..., "body": ...}.
std::string packed_layouts();

}  // namespace tactor
