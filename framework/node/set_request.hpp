// Requests of a node to its run: to set a parameter of another node, or to end the run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "framework/core/message.hpp"

namespace tactor {

enum class RequestKind : std::int32_t { set, set_number, end_run };

/// The session carries out the request, as its owner would by `Session::set` and `Session::stop`. Under the virtual
/// clock it does so at the next whole millisecond, live within its own period (20 ms). A replay ignores requests: the
/// recording tells what was set. A type that sends them declares what it may set (Declare::sets).
///
/// Requests are carried out one after the other. The next one waits until the setting before it is in force: no step
/// with older parameters of that node is running any more. The node that asked is then told (Node::request_done). A
/// refused request ends the run; its failure begins with `about`.
struct SetRequest {
  static constexpr std::size_t most_about = 64;
  RequestKind kind = RequestKind::set;
  std::int32_t setting = 0;  ///< index into NodeInfo::sets
  double number = 0;         ///< in the SI unit of the parameter
  std::int32_t about_length = 0;
  std::array<std::uint8_t, most_about> about{};  ///< UTF-8
};

/// The request for a declared setting. `about` has at most `most_about` bytes.
SetRequest set_request(std::size_t setting, std::string_view about = {});
/// The request for another number in its place, in the SI unit of the parameter.
SetRequest number_request(std::size_t setting, double number, std::string_view about = {});
/// The request to end the run.
SetRequest end_request();
/// What a request is for.
std::string_view about_of(const SetRequest& request);

template <>
const MessageType& message_type<SetRequest>();

}  // namespace tactor
