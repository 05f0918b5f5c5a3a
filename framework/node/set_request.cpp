#include "framework/node/set_request.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<SetRequest>() {
  static const MessageType type =
      Describe<SetRequest>("SetRequest")
          .choice("kind", &SetRequest::kind, {{"set", RequestKind::set}, {"end_run", RequestKind::end_run}})
          .field("length", "1", &SetRequest::length)
          .field("text", "1", &SetRequest::text)
          .type();
  return type;
}

SetRequest set_request(std::string_view text) {
  TACTOR_DEMAND(text.size() <= SetRequest::most_text);
  SetRequest request;
  request.length = static_cast<std::int32_t>(text.size());
  std::copy(text.begin(), text.end(), request.text.begin());
  return request;
}

std::string_view text_of(const SetRequest& request) {
  return {reinterpret_cast<const char*>(request.text.data()), static_cast<std::size_t>(request.length)};
}

}  // namespace tactor
