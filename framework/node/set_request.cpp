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
          .field("about_length", "1", &SetRequest::about_length)
          .field("about", "1", &SetRequest::about)
          .type();
  return type;
}

SetRequest set_request(std::string_view text, std::string_view about) {
  TACTOR_DEMAND(text.size() <= SetRequest::most_text && about.size() <= SetRequest::most_about);
  SetRequest request;
  request.length = static_cast<std::int32_t>(text.size());
  std::copy(text.begin(), text.end(), request.text.begin());
  request.about_length = static_cast<std::int32_t>(about.size());
  std::copy(about.begin(), about.end(), request.about.begin());
  return request;
}

std::string_view text_of(const SetRequest& request) {
  return {reinterpret_cast<const char*>(request.text.data()), static_cast<std::size_t>(request.length)};
}

std::string_view about_of(const SetRequest& request) {
  return {reinterpret_cast<const char*>(request.about.data()), static_cast<std::size_t>(request.about_length)};
}

}  // namespace tactor
