#include "devices/guard/lines.hpp"

#include "framework/core/bytes.hpp"
#include "framework/core/check.hpp"

#ifdef TACTOR_GUARD_MODBUS
#include "devices/modbus/modbus_link.hpp"
#include "devices/modbus/profile_fields.hpp"
#endif
#ifdef TACTOR_GUARD_USB
#include "devices/falcon/falcon_link.hpp"
#include "devices/usb/usb_link.hpp"
#include "devices/usb/usb_profile_fields.hpp"
#endif

namespace tactor {

std::unique_ptr<Link> make_link(const std::string& line, const std::string& bytes) {
  ByteReader reader(bytes);
#ifdef TACTOR_GUARD_MODBUS
  if (line == "modbus") {
    modbus::Profile profile;
    modbus::Endpoint endpoint;
    reader(profile, endpoint);
    return std::make_unique<modbus::ModbusLink>(std::move(profile), std::move(endpoint));
  }
#endif
#ifdef TACTOR_GUARD_USB
  UsbChoice choice;
  if (line == "usb") {
    UsbProfile profile;
    reader(profile, choice);
    return std::make_unique<UsbLink>(std::move(profile), choice);
  }
  if (line == "falcon") {
    std::vector<std::uint8_t> firmware;
    reader(firmware, choice);
    return std::make_unique<FalconLink>(std::move(firmware), choice);
  }
#endif
  throw RunError("this guard was built without lines of the kind " + line);
}

}  // namespace tactor
