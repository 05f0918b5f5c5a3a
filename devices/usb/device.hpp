// usb.device: a haptic device on the USB whose reports a profile describes.
#pragma once

#include <filesystem>
#include <string>

#include "devices/hardware/declare_hardware.hpp"

namespace tactor {

class UsbLink;
struct UsbProfile;

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

  void start(StepContext& context) override;
  void follow(const Node& tested) override;

 private:
  struct Parts;
  UsbDevice(const Params& params, const NodeContext& context, Parts parts);

  UsbLink* link_;  // the runner's; touched by `start` alone, before its thread is made
  bool follows_ = false;
};

}  // namespace tactor
