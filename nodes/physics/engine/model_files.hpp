// The files that a model of MuJoCo is made of.
#pragma once

#include <filesystem>
#include <vector>

namespace tactor {

/// The files that the model in `file` names, and those that the models among them name: included models, meshes,
/// textures, height fields. Looks for `file="..."` beside the model and in the folders that it names. Files that are
/// not there are left out. Throws InputError where a model cannot be read.
std::vector<std::filesystem::path> model_files(const std::filesystem::path& file);

}  // namespace tactor
