// Reads the texts that a page sends.
#pragma once

#include <optional>
#include <string_view>

#include "app/view/view_server.hpp"

namespace tactor {

/// What the text asks for; nothing where it is no message of the protocol: no JSON, a wrong type, a number that is not
/// finite, a quaternion that is no rotation, a text too long.
std::optional<ClientMessage> read_client_text(std::string_view text);

}  // namespace tactor
