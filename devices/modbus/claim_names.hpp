// What an endpoint is called by those who must not use it at the same time, whichever name it goes by.
#pragma once

#include <string>
#include <vector>

#include "devices/modbus/client.hpp"

namespace tactor::modbus {

/// Of a serial port the number that the system gives it, so that all its names and links mean the same. Over TCP a name
/// for each address of the host, where those of this machine all mean the same. Empty where there is no such port or
/// host, which connecting finds out.
std::vector<std::string> claim_names(const Endpoint& endpoint);

}  // namespace tactor::modbus
