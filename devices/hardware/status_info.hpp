// What a device tells of its state beside its pose, as its declaration lists it.
#pragma once

#include <string>

namespace tactor {

/// One value of the state of a device beside its pose: the temperature of a motor, whether a brake is on.
struct StatusInfo {
  std::string name;  ///< `motor_temperature`
  std::string unit;  ///< `degC`; `1` for a number without a unit and for yes (1) and no (0)
  std::string doc;   ///< what it is, in one sentence
};

}  // namespace tactor
