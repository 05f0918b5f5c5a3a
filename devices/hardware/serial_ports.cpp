#include "devices/hardware/serial_ports.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

namespace tactor {

namespace fs = std::filesystem;

namespace {

// Only those with hardware behind them; a ttyS without a port is of the platform bus.
constexpr std::array<std::string_view, 4> prefixes{"ttyUSB", "ttyACM", "ttyAMA", "ttyXR"};

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

std::vector<SerialPort> serial_ports(const fs::path& classes, const fs::path& files) {
  std::vector<SerialPort> ports;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(classes, error)) {
    const std::string name = entry.path().filename().string();
    const auto fits = [&name](std::string_view prefix) { return name.starts_with(prefix); };
    if (std::none_of(prefixes.begin(), prefixes.end(), fits)) continue;
    const fs::path file = files / name;
    if (!fs::exists(file, error)) continue;
    ports.push_back({file, usb_names(entry.path() / "device"), access(file.c_str(), R_OK | W_OK) == 0});
  }
  std::sort(ports.begin(), ports.end(), [](const SerialPort& a, const SerialPort& b) { return a.file < b.file; });
  return ports;
}

}  // namespace tactor
