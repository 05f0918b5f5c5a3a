// Requests of a node to its run: to set a parameter of another node, or to end the run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "framework/core/message.hpp"

namespace tactor {

enum class RequestKind : std::int32_t { set, end_run };

/// The session carries out the request, as its owner would by `Session::set` and `Session::stop`. Under the virtual
/// clock it does so at the next whole millisecond, live within its own period (20 ms). A replay ignores requests: the
/// recording tells what was set. A type that sends them declares what it may set (Declare::sets).
///
/// Requests are carried out one after the other. The next one waits until the setting before it is in force: no step
/// with older parameters of that node is running any more. The node that asked is then told (Node::request_done). A
/// refused request ends the run; its failure begins with `about`.
struct SetRequest {
  static constexpr std::size_t most_text = 256;
  static constexpr std::size_t most_about = 64;
  RequestKind kind = RequestKind::set;
  std::int32_t length = 0;                       ///< bytes of `text` in use
  std::array<std::uint8_t, most_text> text{};    ///< `node.parameter=value`, as in a graph file, UTF-8
  std::int32_t about_length = 0;                 ///< bytes of `about` in use
  std::array<std::uint8_t, most_about> about{};  ///< what it is for, UTF-8: `trial 7, interval 1`; or empty
};

/// The request to set; the text has no more than `most_text` bytes, and `about` no more than `most_about`.
SetRequest set_request(std::string_view text, std::string_view about = {});
/// The text of a request.
std::string_view text_of(const SetRequest& request);
/// What a request is for.
std::string_view about_of(const SetRequest& request);

template <>
const MessageType& message_type<SetRequest>();

}  // namespace tactor
