// The serial ports of this machine that a device may be on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tactor {

struct SerialPort {
  std::filesystem::path file;  ///< `/dev/ttyUSB0`
  std::string adapter;         ///< what the system knows of it: maker, product and numbers of a USB adapter
  bool may_open = false;       ///< by this user
};

/// Those of USB adapters and bus cards, by name; none is opened. `classes` is the system's list of terminals, `files`
/// the folder of theirs.
std::vector<SerialPort> serial_ports(const std::filesystem::path& classes = "/sys/class/tty",
                                     const std::filesystem::path& files = "/dev");

/// The group whose members may open this file to read and write; empty where no group may, or it has no name.
std::string group_of(const std::filesystem::path& file);

/// What to do where this user may not open a serial port: the group that may, and the command that adds a user to it.
std::string advice_for_access(const std::filesystem::path& file);

}  // namespace tactor
