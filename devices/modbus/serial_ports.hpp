// The serial ports of this machine that a Modbus line may be on.
#pragma once

#include <string>
#include <vector>

namespace tactor::modbus {

/// A line for each serial port of a USB adapter or a bus card, with what the system knows of it and whether it may be
/// opened. Nothing is sent to it: Modbus has no request that any device may safely be given.
std::vector<std::string> serial_ports();

}  // namespace tactor::modbus
