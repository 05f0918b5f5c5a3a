// The shipped graphs that a machine without hardware runs, by their clocks.
#pragma once

#include <algorithm>
#include <filesystem>
#include <regex>
#include <vector>

#include "tests/support/shipped_graphs.hpp"

namespace tactor::test {

inline std::vector<std::filesystem::path> folders_of_graphs() {
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(graphs)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

inline std::vector<std::filesystem::path> yaml_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// The graphs of all scenes, without those for hardware, which are run beside their emulators elsewhere.
inline std::vector<std::filesystem::path> graphs_with_clock(Clock clock) {
  const std::regex hardware("type: *(modbus|usb|falcon)\\.");
  std::vector<std::filesystem::path> found;
  for (const std::filesystem::path& folder : folders_of_graphs()) {
    if (!std::filesystem::exists(folder / "scene.yaml")) continue;
    for (const std::filesystem::path& file : yaml_files(folder)) {
      if (!std::regex_search(text_in(file), hardware) && loaded(file).clock == clock) found.push_back(file);
    }
  }
  return found;
}

/// What makes a shipped soft body coarse, which saves minutes, beside what is laid over the graph.
inline Over with_few_tetrahedra(const std::filesystem::path& graph, Over over) {
  if (graph.parent_path().filename() == "bunny_soft") over.push_back("scene.bodies.bunny.tetrahedra=500");
  return over;
}

}  // namespace tactor::test
