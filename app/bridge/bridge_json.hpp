// Messages of the bridge as texts of JSON.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "app/bridge/bridge_messages.hpp"

namespace tactor {

std::string to_text(const BridgeStep& step);
std::string to_text(const BridgeResult& result);
std::string to_text(const BridgeError& error);
/// Without a type: a part of `hello`.
std::string to_text(const CouplingParameters& coupling);

/// The message of a client. Throws BridgeRefusal.
std::variant<BridgeNext, BridgeResult> read_client_message(std::string_view text);
/// Throws BridgeRefusal where the text is no step.
BridgeStep read_step(std::string_view text);

}  // namespace tactor
