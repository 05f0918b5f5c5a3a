// What a node asks of the run it is in: to set a parameter of another node, or to end the run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "framework/core/message.hpp"

namespace tactor {

enum class RequestKind : std::int32_t { set, end_run };

/// The session does what is asked, as its owner would by `Session::set` and `Session::stop`. Under the virtual clock it
/// does so at the next whole millisecond, live within its own period (20 ms). In a replay it does not: the recording
/// tells what was set. A type that sends it declares what it may set (Declare::sets).
struct SetRequest {
  static constexpr std::size_t most_text = 256;
  RequestKind kind = RequestKind::set;
  std::int32_t length = 0;                     ///< bytes of `text` in use
  std::array<std::uint8_t, most_text> text{};  ///< `node.parameter=value`, as in a graph file, UTF-8
};

/// The request to set; the text has no more than `most_text` bytes.
SetRequest set_request(std::string_view text);
/// The text of a request.
std::string_view text_of(const SetRequest& request);

template <>
const MessageType& message_type<SetRequest>();

}  // namespace tactor
