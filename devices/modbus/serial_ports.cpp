#include "devices/modbus/serial_ports.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace tactor::modbus {

namespace fs = std::filesystem;

namespace {

std::string first_line(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

/// What a USB adapter says of itself, from the folder of its tty in /sys.
std::string usb_names(const fs::path& device) {
  std::error_code error;
  for (fs::path folder = fs::canonical(device, error); !error && folder.has_relative_path();
       folder = folder.parent_path()) {
    if (!fs::exists(folder / "idVendor", error)) continue;
    const std::string id = first_line(folder / "idVendor") + ":" + first_line(folder / "idProduct");
    return first_line(folder / "manufacturer") + " " + first_line(folder / "product") + " (" + id + ")";
  }
  return "a serial card";
}

}  // namespace

std::vector<std::string> serial_ports() {
  std::vector<std::string> lines;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/sys/class/tty", error)) {
    const std::string name = entry.path().filename().string();
    // Only those with hardware behind them; a ttyS without a port is of the platform bus.
    const bool usb = name.starts_with("ttyUSB") || name.starts_with("ttyACM");
    if (!usb && !(name.starts_with("ttyAMA") || name.starts_with("ttyXR"))) continue;
    const std::string path = "/dev/" + name;
    const bool open = access(path.c_str(), R_OK | W_OK) == 0;
    lines.push_back("serial port rtu:" + path + ": " + usb_names(entry.path() / "device") +
                    (open ? "" : "; may not be opened by this user: see `tactor doctor`"));
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

}  // namespace tactor::modbus
