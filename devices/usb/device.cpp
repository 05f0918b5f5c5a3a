#include "devices/usb/device.hpp"

#include <cmath>

#include "devices/hardware/profile_files.hpp"
#include "devices/usb/usb_link.hpp"
#include "devices/usb/usb_profile_fields.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr Duration calibration_time{300'000'000};

UsbProfile profile_of(const UsbDevice::Params& params) {
  return read_usb_profile(params.profile);
}

HardwareParts parts_of(const UsbDevice::Params& params) {
  const UsbProfile profile = profile_of(params);
  const UsbChoice choice{params.serial, params.file};
  HardwareParts parts;
  ByteWriter bytes;
  bytes(profile, choice);
  parts.guardable = {"usb", bytes.take()};
  parts.link = std::make_unique<UsbLink>(profile, choice);
  parts.kinematics = profile.make_kinematics();
  parts.limits.axes = static_cast<int>(profile.axes.size());
  parts.limits.effort_max = profile.values(&UsbAxis::effort_max);
  parts.limits.speed_max = profile.values(&UsbAxis::speed_max);
  parts.limits.jump_tolerance = profile.values(&UsbAxis::jump_tolerance);
  parts.rate = profile.rate;
  // A device that sends on its own has its report ready for up to a frame; one that only answers has two commands
  // ahead.
  const Duration frame = Duration::from_rate(profile.rate);
  parts.delay_in = profile.asks_first ? Duration{} : frame;
  parts.delay_out = profile.asks_first ? frame * 2 : Duration{};
  parts.buttons = static_cast<int>(profile.input.buttons.size());
  parts.resolution = profile.resolution;
  return parts;
}

std::string calibrate(const UsbDevice::Params& params, const Ask& ask) {
  const UsbProfile profile = profile_of(params);
  if (profile.calibration.empty()) return profile.name + " needs no calibration";
  UsbLink link(profile, {params.serial, params.file});
  if (!ask("Put the handle of " + link.name() + " into its pose (" + profile.calibration + ") and hold it still.")) {
    throw InputError(link.name() + ": not calibrated");
  }
  const std::vector<double> counts = link.calibrate(calibration_time);
  std::string text = link.name() + " is calibrated until it is unplugged; its counters showed";
  for (const double count : counts) text += " " + std::to_string(static_cast<long long>(std::llround(count)));
  return text;
}

std::string line_of(const UsbProfile& profile, const UsbDeviceInfo& info) {
  std::string text = profile.name + ": " + profile.title;
  if (!info.path.empty()) text += ", at " + info.path;
  if (!info.serial.empty()) text += ", serial number " + info.serial;
  if (!info.may_open) text += "; this user may not open it: `tactor doctor` says how to allow it";
  return text + " (type: usb.device, profile: " + profile.name + ")";
}

std::vector<std::string> discover(std::vector<std::string>& notes) {
  const std::vector<UsbProfile> profiles = all_usb_profiles(notes);
  std::vector<UsbNumbers> kinds;
  for (const UsbProfile& profile : profiles) kinds.push_back({profile.vendor, profile.product});
  UsbBus bus;
  std::vector<UsbDeviceInfo> devices = bus.devices(kinds);
  std::string ignored;
  // One that TACTOR_USB_FILE names is on no bus that can be searched.
  for (const UsbProfile& profile : profiles) {
    const UsbSelector selector = selector_of(profile.vendor, profile.product, {});
    if (selector.file.empty()) break;
    if (const auto port = bus.open(selector, ignored)) devices.push_back(port->info());
  }
  std::vector<std::string> lines;
  for (const UsbDeviceInfo& info : devices) {
    for (const UsbProfile& profile : profiles) {
      const bool fits = info.vendor == profile.vendor && info.product == profile.product &&
                        (profile.product_text.empty() || !info.may_open || profile.product_text == info.name);
      if (fits) lines.push_back(line_of(profile, info));
    }
  }
  return lines;
}

}  // namespace

UsbDevice::UsbDevice(const Params& params, const NodeContext& context)
    : HardwareDevice(params, context, parts_of(params)) {}

NodeInfo UsbDevice::declare() {
  using P = Params;
  Declare<UsbDevice> declaration("usb.device", "A haptic device on the USB, described by a profile.");
  declaration.details(
      "Reports of fixed layout come by interrupt or bulk transfers (libusb) on a thread of their own; commands go the "
      "other way. The profile (YAML) describes the device, the meaning of the bytes, the geometry and the limits of "
      "the motors; docs/howto/usb.md has its format. Shipped: polhem. If the counters of a device have no zero, "
      "calibrate it by `tactor device calibrate` after plugging it in; otherwise a run does not start.");
  declaration
      .file("profile", &P::profile, true, "the profile: the path of a file, or a shipped one such as polhem",
            profiles_of("usb"))
      .text("serial", &P::serial, "", "serial number of the device, if several are attached; empty: any")
      .text("file", &P::file, "", "the device's file (/dev/bus/usb/...) instead of a search; empty: search");
  declare_hardware(declaration);
  declaration.calibrate(calibrate).discover(discover);
  return declaration.info();
}

}  // namespace tactor
