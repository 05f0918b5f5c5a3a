// Which shared libraries a program needs, by the system's own loader.
#pragma once

#include <filesystem>
#include <set>
#include <vector>

namespace tactor {

/// The files of all libraries that the loader would load for these programs and libraries, without those of the C
/// library, which belong to the machine. Throws RunError where it finds one missing.
std::set<std::filesystem::path> shared_libraries(const std::vector<std::filesystem::path>& binaries);

}  // namespace tactor
