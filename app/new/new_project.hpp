// Writes a project of the user's own out of one of the examples that come with Tactor.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tactor {

/// What `tactor new` can copy: a folder of share/tactor/examples.
enum class ProjectKind { node, device, message, study, physics, mujoco };

/// Writes the folder `folder`/NAME, where NAME is that of the project, and returns its files. A project in C++ builds
/// with find_package(tactor) and has a test. Its graph or study is called after it: NAME.yaml.
///
/// `name` is that of the library, `mylab`, or with that of the node, `mylab.smooth`; a study, physics and a model of
/// MuJoCo have no node. Throws InputError where it is no such name, where a library of that name comes with Tactor, and
/// where the folder is there already; RunError where the disk refuses.
std::vector<std::filesystem::path> new_project(ProjectKind kind, const std::string& name,
                                               const std::filesystem::path& folder);

/// The same for a study of that graph, a file or a name of a graph, which the study names as it stands, in quotes.
std::vector<std::filesystem::path> new_study(const std::string& name, const std::string& graph,
                                             const std::filesystem::path& folder);

}  // namespace tactor
