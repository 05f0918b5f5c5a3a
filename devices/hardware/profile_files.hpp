// Where the profiles of devices lie, by the kind of their line: `modbus`, `usb`.
#pragma once

#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tactor {

/// The folders whose folders `modbus` and `usb` hold profiles, those that come first first: those of
/// TACTOR_PROFILE_PATH (with `:` between them), and those that belong to the program. They need not be there.
std::vector<std::filesystem::path> profile_folders();

/// The file of a profile: `name` as a path, where it has a `/` or ends in `.yaml`, or else a profile of that kind by
/// its name (`iris_orca`, `modbus/iris_orca.yaml`). Nothing where there is none.
std::optional<std::filesystem::path> find_profile(const std::string& kind, const std::string& name);

/// The same. Throws InputError, with the profiles that there are and the nearest of them, where there is none.
std::filesystem::path profile_named(const std::string& kind, const std::string& name);

/// All profiles of a kind in the folders, each name once, as find_profile would find it; by folder and name.
std::vector<std::filesystem::path> profile_files(const std::string& kind);

/// `FILE: WHY` in one line, for a profile that cannot be used: the first error, and how many more there are.
std::string broken_profile(const std::filesystem::path& file, const std::exception& error);

}  // namespace tactor
