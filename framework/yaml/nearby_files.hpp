// What there is where a file was looked for and not found, for error texts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tactor {

/// The files that lie where `looked` was looked for in vain: those of the same ending, or `.yaml` where it has none, as
/// `; FOLDER holds a.yaml, b.yaml; did you mean "a.yaml"?`. Names at most 40 of a folder; empty where there are none.
std::string nearby_files(const std::vector<std::filesystem::path>& looked);

}  // namespace tactor
