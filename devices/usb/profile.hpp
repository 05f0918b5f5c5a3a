// What Tactor knows of a USB device: its numbers, its reports, its geometry, and how it is emulated.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "devices/hardware/kinematics.hpp"
#include "devices/usb/report_layout.hpp"
#include "devices/usb/usb_port.hpp"

namespace tactor {

/// Of an axis beside what its fields say.
struct UsbAxis {
  std::string name;
  double speed_max = 1;       ///< m/s or rad/s
  double jump_tolerance = 0;  ///< m or rad
  double effort_max = 0;      ///< N or N m: that of the largest count that may be sent
};

/// How the device is emulated.
struct UsbEmulation {
  double mass = 0.6, damping = 6.5, stiffness = 135, friction = 0.2;  ///< of hand and handle; kg, N s/m, N/m, N s/m
  double hold = 0.5, approach = 1;                                    ///< s
  double watchdog = 0.5;                                              ///< s without a command, then no effort
  std::vector<double> start{0, 0, 0};                                 ///< m, where the hand holds the handle first
  std::vector<double> times;                                          ///< s, of its path
  std::vector<Vec3> points;                                           ///< m
};

struct UsbProfile {
  std::string name;   ///< of the file, without its ending
  std::string title;  ///< a line
  std::uint16_t vendor = 0, product = 0;
  std::string product_text;  ///< what the device must call itself; empty: anything
  UsbTransfers transfers;
  double rate = 1000;                   ///< Hz, of reports
  Duration report_timeout{20'000'000};  ///< without a report for so long a cycle has failed
  bool asks_first = false;              ///< the device answers each report with one of its own, and else is silent
  InputLayout input;
  OutputLayout output;
  std::vector<UsbAxis> axes;
  double resolution = 1e-5;     ///< m, a step of the position at the handle
  std::string calibration;      ///< the pose that a person puts the handle into; empty: none is needed
  std::string kinematics;       ///< `linear` or `wooden`
  std::vector<double> numbers;  ///< of the kinematics: directions one after another; or La, Lb, Lc and O
  UsbEmulation emulation;

  /// Makes the geometry.
  [[nodiscard]] std::unique_ptr<Kinematics> make_kinematics() const;
  /// The efforts and speeds of the axes.
  [[nodiscard]] AxisValues values(double UsbAxis::*member) const;
};

/// Reads a profile. Throws YamlError with every error there is, each with file:line:column.
UsbProfile read_usb_profile(const std::filesystem::path& file);
/// The same of a text; `file` is what errors call it.
UsbProfile parse_usb_profile(const std::string& text, const std::string& file);

/// All profiles in the folders that can be read; for each of the others a line in `notes`.
std::vector<UsbProfile> all_usb_profiles(std::vector<std::string>& notes);

}  // namespace tactor
