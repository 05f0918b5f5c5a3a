// A scene with one method after another, as a command line names them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/study/study_command.hpp"

namespace tactor {

/// `scene`: a graph file, or a folder of shipped graphs with a file scene.yaml (`bunny`). A method is a graph of that
/// name beside the scene (`off`), or a file that is laid over the scene (`kalman` of graphs/methods). Throws InputError
/// where there is no such scene or method.
std::vector<ComparedGraph> scene_with_methods(const std::filesystem::path& scene,
                                              const std::vector<std::string>& methods);

}  // namespace tactor
