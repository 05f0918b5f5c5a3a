#include "devices/falcon/device.hpp"

#include "devices/falcon/delta_kinematics.hpp"
#include "devices/falcon/falcon_link.hpp"
#include "devices/falcon/protocol.hpp"
#include "devices/usb/usb_profile_fields.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

std::vector<std::uint8_t> firmware_of(const Falcon::Params& params) {
  return params.firmware.empty() ? std::vector<std::uint8_t>{} : read_falcon_firmware(params.firmware);
}

HardwareParts parts_of(const Falcon::Params& params) {
  const UsbChoice choice{params.serial, params.file};
  std::vector<std::uint8_t> firmware = firmware_of(params);
  HardwareParts parts;
  ByteWriter bytes;
  bytes(firmware, choice);
  parts.guardable = {"falcon", bytes.take()};
  parts.link = std::make_unique<FalconLink>(std::move(firmware), choice);
  parts.kinematics = std::make_unique<DeltaKinematics>();
  parts.limits.axes = 3;
  parts.limits.effort_max = {0.4096, 0.4096, 0.4096};
  parts.limits.speed_max = {40, 40, 40};
  parts.limits.jump_tolerance = {0.05, 0.05, 0.05};
  parts.rate = 1000;
  parts.buttons = 4;
  parts.resolution = 4e-5;
  return parts;
}

std::vector<std::string> discover(std::vector<std::string>&) {
  UsbBus bus;
  std::vector<std::string> lines;
  const auto tell = [&lines](const UsbDeviceInfo& info) {
    std::string line = "falcon: Novint Falcon";
    if (!info.path.empty()) line += ", at " + info.path;
    if (!info.may_open) line += "; this user may not open it: `tactor doctor` says how to allow it";
    lines.push_back(line + " (type: falcon.device)");
  };
  const UsbNumbers kind[] = {{falcon::vendor, falcon::product}};
  for (const UsbDeviceInfo& info : bus.devices(kind)) tell(info);
  const UsbSelector selector = selector_of(falcon::vendor, falcon::product, {});
  std::string ignored;
  if (!selector.file.empty()) {
    if (const auto port = bus.open(selector, ignored)) tell(port->info());
  }
  return lines;
}

}  // namespace

Falcon::Falcon(const Params& params, const NodeContext& context) : HardwareDevice(params, context, parts_of(params)) {}

NodeInfo Falcon::declare() {
  using P = Params;
  Declare<Falcon> declaration("falcon.device", "A Novint Falcon.");
  declaration.details(
      "It is driven through its FTDI chip by libusb, with packets at 1 kHz. Tactor may not ship the firmware: "
      "`firmware` is the path of the image that came with the device's driver; a device that already has its firmware "
      "needs none. After switching it on, home it by pulling the handle out and pushing it in. Until then, and "
      "whenever a packet says that an encoder has no zero, the motors get no force. Positions by the delta geometry "
      "that libnifalcon publishes, with z along the handle's way out; torques J^T F. docs/howto/usb.md tells more.");
  declaration.file("firmware", &P::firmware, false, "the firmware image; empty: the device already has it")
      .text("serial", &P::serial, "", "serial number of the device, if several are attached; empty: any")
      .text("file", &P::file, "", "the device's file (/dev/bus/usb/...) instead of a search; empty: search");
  HardwareParams defaults;
  defaults.connect_timeout = Duration{60'000'000'000};  // firmware and homing by hand
  declare_hardware(declaration, defaults);
  declaration.discover(discover);
  return declaration.info();
}

}  // namespace tactor
