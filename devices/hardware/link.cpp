#include "devices/hardware/link.hpp"

#include <array>

#include "framework/core/check.hpp"

namespace tactor {

std::string_view name_of(LinkError error) {
  static constexpr std::array<std::string_view, link_error_count> names{
      "none", "timeout", "crc", "exception", "protocol", "reset", "disconnected", "identity", "device_fault"};
  return names[static_cast<std::size_t>(error)];
}

bool Link::exchange(const LinkCommand&, LinkSample&, LinkFailure&) {
  TACTOR_DEMAND(!"a link has `exchange`, or the pace `callback`");
  return false;
}

void Link::start(LinkTurn&) {
  TACTOR_DEMAND(!"a link of the pace `callback` has `start`");
}

}  // namespace tactor
