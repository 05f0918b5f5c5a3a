// What a Foxglove viewer asks for, read from its text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tactor {

struct FoxgloveRequest {
  enum class Kind : std::uint8_t {
    subscribe,
    unsubscribe,
    get_parameters,
    follow_parameters,
    unfollow_parameters,
    set_parameters,
    other,  ///< what this server has no answer for
  };
  Kind kind = Kind::other;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> subscriptions;  ///< of subscribe: its id, and the channel's
  std::vector<std::uint32_t> ids;                                      ///< of unsubscribe: of subscriptions
  std::vector<std::string> names;                                      ///< of parameters; none: all
  std::string id;                                                      ///< of the request; may be empty
};

/// Empty if the text is not a valid message of a viewer.
std::optional<FoxgloveRequest> read_foxglove_text(std::string_view text);

}  // namespace tactor
