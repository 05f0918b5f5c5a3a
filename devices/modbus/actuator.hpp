// modbus.actuator: a real actuator on Modbus, TCP or a serial line.
#pragma once

#include <filesystem>
#include <string>

#include "devices/hardware/hardware_device.hpp"
#include "devices/modbus/modbus_link.hpp"
#include "framework/node/info.hpp"

namespace tactor::modbus {

/// The node: a HardwareDevice over a ModbusLink.
class Actuator final : public HardwareDevice {
 public:
  struct Params : HardwareParams {
    std::filesystem::path profile;
    std::string connect;
    std::int32_t unit = 0;      ///< 0: the profile's
    std::int32_t baud = 0;      ///< 0: the profile's
    double link_rate = 0;       ///< Hz; 0: as the line allows
    Duration response_timeout;  ///< 0: the profile's
  };

  Actuator(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

/// What parameters come to: a profile with the line's settings laid over it, and the rate.
struct Setup {
  Profile profile;
  Endpoint endpoint;
  double rate = 0;     ///< Hz, of the cycles
  LineRate line;       ///< what the line can carry
  std::string danger;  ///< what the user must know of the device before a force; empty: nothing
};

/// Throws YamlError for the profile, and InputError for an invalid endpoint, for a rate beyond the line, and for a
/// watchdog of the device that runs out within two cycles.
Setup make_setup(const Actuator::Params& params);

}  // namespace tactor::modbus
