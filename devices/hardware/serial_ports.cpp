#include "devices/hardware/serial_ports.hpp"

#include <grp.h>
#include <sys/stat.h>
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

std::string group_of(const fs::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0 || (status.st_mode & (S_IRGRP | S_IWGRP)) != (S_IRGRP | S_IWGRP)) return {};
  group entry{};
  group* found = nullptr;
  std::array<char, 16384> text{};
  if (getgrgid_r(status.st_gid, &entry, text.data(), text.size(), &found) != 0 || found == nullptr) return {};
  return found->gr_name;
}

std::string advice_for_access(const fs::path& file) {
  const std::string name = group_of(file);
  if (name.empty()) {
    return "this user may not open " + file.string() +
           ", and no group may: add a udev rule that gives it a group, such as dialout";
  }
  return "this user may not open " + file.string() + ", which belongs to the group " + name + ": sudo usermod -aG " +
         name + " $USER, then log in anew";
}

}  // namespace tactor
