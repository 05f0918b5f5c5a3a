// How the devices are emulated that Tactor knows: the Falcon, and those of profiles.
#pragma once

#include "devices/usb/emulator/emulation.hpp"
#include "devices/usb/profile.hpp"

namespace tactor {

/// A Falcon without its firmware, in a hand that moves it out and in.
Emulation falcon_emulation();
/// The device of a profile, in the hand that the profile tells of.
Emulation emulation_of(const UsbProfile& profile);

}  // namespace tactor
