#include "devices/hardware/link.hpp"

namespace tactor {

std::string_view name_of(LinkError error) {
  static constexpr std::array<std::string_view, link_error_count> names{
      "none", "timeout", "crc", "exception", "protocol", "reset", "disconnected", "identity", "device_fault"};
  return names[static_cast<std::size_t>(error)];
}

}  // namespace tactor
