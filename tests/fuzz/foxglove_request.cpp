// What a viewer of Foxglove may send, and the protocols that it offers.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "app/view/server/foxglove_text.hpp"
#include "app/web/request_rules.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto request = read_foxglove_text(text)) {
    using Kind = FoxgloveRequest::Kind;
    fuzz::require(request->subscriptions.empty() || request->kind == Kind::subscribe, "only `subscribe` subscribes");
    fuzz::require(request->ids.empty() || request->kind == Kind::unsubscribe, "only `unsubscribe` ends subscriptions");
    fuzz::require(request->names.empty() || request->kind == Kind::get_parameters ||
                      request->kind == Kind::follow_parameters || request->kind == Kind::unfollow_parameters,
                  "only what asks for parameters names them");
    fuzz::require(request->id.size() <= size, "an id is out of the text");
  }
  constexpr std::array<std::string_view, 2> known{"one", "two"};
  if (const auto chosen = offered_protocol(text, known)) {
    fuzz::require(text.find(*chosen) != std::string_view::npos, "a protocol is what was offered");
  }
  return 0;
}
