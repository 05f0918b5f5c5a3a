#include "framework/node/set_request.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<SetRequest>() {
  static const MessageType type =
      Describe<SetRequest>("SetRequest", "",
                           "A request of a node to its run: to set a parameter of another node, or to end the run. "
                           "Stamped valid for the step that made it.")
          .choice("kind", &SetRequest::kind,
                  {{"set", RequestKind::set, "The parameter of a declared setting gets the declared value."},
                   {"set_number", RequestKind::set_number, "The parameter of a declared setting gets `number`."},
                   {"end_run", RequestKind::end_run, "The run ends."}},
                  "Request that is made.")
          .field("setting", "1", &SetRequest::setting,
                 "Index of the setting, counted from 0 in the order in which the node's type declares them.")
          .field("number", "1", &SetRequest::number,
                 "Value for a request `set_number`, in the SI unit of the parameter.")
          .field("about_length", "1", &SetRequest::about_length, "Bytes of `about` in use.")
          .field("about", "1", &SetRequest::about,
                 "Purpose of the request in UTF-8, such as `trial 7, interval 1`. A failure names it.")
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
