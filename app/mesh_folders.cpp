#include "app/mesh_folders.hpp"

#include <cstdlib>

#include "devices/hardware/profile_files.hpp"

namespace tactor {

namespace fs = std::filesystem;

std::vector<fs::path> mesh_folders() {
  std::vector<fs::path> folders;
  if (const char* folder = std::getenv("TACTOR_MESH_PATH")) folders.emplace_back(folder);
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  folders.push_back(program.parent_path() / "meshes");
  folders.push_back(program.parent_path() / "share" / "tactor" / "meshes");
  for (const fs::path& folder : profile_folders()) folders.push_back(folder);
  return folders;
}

}  // namespace tactor
