// Where meshes and profiles of devices that graphs name are looked for after the graph's own folder.
#pragma once

#include <filesystem>
#include <vector>

namespace tactor {

/// TACTOR_MESH_PATH, then the folders of this build or installation.
std::vector<std::filesystem::path> mesh_folders();

}  // namespace tactor
