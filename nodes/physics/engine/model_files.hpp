// The files that a model of MuJoCo is made of.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tactor {

/// The files that the model in `file` names, and those that the models among them name: included models, meshes,
/// textures, height fields. Looks for each `file="..."` beside all of these models and in the folders that any of them
/// names, which count from the main model's folder or from that of the one that names them. Files that are not there
/// are left out. Throws InputError where a model cannot be read.
std::vector<std::filesystem::path> model_files(const std::filesystem::path& file);

/// A hash of the contents of the model in `file` and of its files, wherever they lie. Throws as model_files does.
std::uint64_t hash_of_files(const std::filesystem::path& file);

}  // namespace tactor
