// The profiles of devices, by the kind of their line: `modbus`, `usb`.
#pragma once

#include <exception>
#include <filesystem>
#include <string>

#include "framework/core/file_lookup.hpp"

namespace tactor {

/// The profiles of devices on that kind of line: in its folder in those of TACTOR_PROFILE_PATH and of the program.
FileKind profiles_of(const std::string& line);

/// `FILE: WHY` in one line, for a profile that cannot be used: the first error, and how many more there are.
std::string broken_profile(const std::filesystem::path& file, const std::exception& error);

}  // namespace tactor
