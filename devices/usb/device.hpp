// usb.device: a haptic device on the USB whose reports a profile describes.
#pragma once

#include <filesystem>
#include <string>

#include "devices/hardware/declare_hardware.hpp"

namespace tactor {

/// See HardwareDevice; the line is a UsbLink. A device that needs a calibration and has none does not start: `start`
/// throws InputError, which says what to do.
class UsbDevice final : public HardwareDevice {
 public:
  struct Params : HardwareParams {
    std::filesystem::path profile;
    std::string serial;
    std::string file;
  };
  UsbDevice(const Params& params, const NodeContext& context);
  static NodeInfo declare();
};

}  // namespace tactor
