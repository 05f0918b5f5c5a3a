// Whether this user may reach the devices of this machine: part of the verb `doctor`.
#pragma once

#include <vector>

#include "framework/realtime/system_findings.hpp"

namespace tactor {

/// The findings `ports`, `serial_group` and `udev_rule`. They are about devices alone, and do not count for real time.
std::vector<Finding> device_findings();

}  // namespace tactor
