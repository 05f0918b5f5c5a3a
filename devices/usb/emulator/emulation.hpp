// All that an emulated USB device is, as a small text that a library in front of the C library can read by itself.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "devices/usb/emulator/emulated_arm.hpp"
#include "devices/usb/emulator/fault_script.hpp"
#include "devices/usb/report_layout.hpp"

namespace tactor {

struct Emulation {
  std::string kind = "report";  ///< `report` or `falcon`
  std::string path;             ///< of its file, as the host opens it
  std::uint16_t vendor = 0, product = 0;
  std::string name;         ///< what it calls itself
  std::string serial;       ///< the beginning of its serial number; the number of times it was plugged in follows
  bool bulk = false;        ///< its transfers; else interrupt
  bool asks_first = false;  ///< it sends a report after each that it gets, and one first
  InputLayout input;
  OutputLayout output;
  double watchdog = 0.5;  ///< s without a command, then no effort
  std::string geometry;   ///< see make_arm_geometry
  std::vector<double> numbers;
  Vec3 start;  ///< m, of the handle
  HandModel hand;
  std::vector<FaultOrder> faults;
  std::string state;    ///< a file with what the device knows while it has power, shared by all who open it
  std::string trace;    ///< a CSV file for what it does; empty: none
  std::string control;  ///< a FIFO for the names of faults; empty: none
};

/// Lines of a key and its value. `read` gives what is wrong, or nothing.
std::string to_text(const Emulation& emulation);
std::string read_emulation(const std::string& text, Emulation& emulation);

}  // namespace tactor
