#include "framework/node/set_request.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<SetRequest>() {
  static const MessageType type =
      Describe<SetRequest>("SetRequest")
          .choice(
              "kind", &SetRequest::kind,
              {{"set", RequestKind::set}, {"set_number", RequestKind::set_number}, {"end_run", RequestKind::end_run}})
          .field("setting", "1", &SetRequest::setting)
          .field("number", "1", &SetRequest::number)
          .field("about_length", "1", &SetRequest::about_length)
          .field("about", "1", &SetRequest::about)
          .type();
  return type;
}

SetRequest set_request(std::size_t setting, std::string_view about) {
  TACTOR_DEMAND(about.size() <= SetRequest::most_about);
  SetRequest request;
  request.setting = static_cast<std::int32_t>(setting);
  request.about_length = static_cast<std::int32_t>(about.size());
  std::copy(about.begin(), about.end(), request.about.begin());
  return request;
}

SetRequest number_request(std::size_t setting, double number, std::string_view about) {
  SetRequest request = set_request(setting, about);
  request.kind = RequestKind::set_number;
  request.number = number;
  return request;
}

SetRequest end_request() {
  SetRequest request;
  request.kind = RequestKind::end_run;
  return request;
}

std::string_view about_of(const SetRequest& request) {
  return {reinterpret_cast<const char*>(request.about.data()), static_cast<std::size_t>(request.about_length)};
}

}  // namespace tactor
