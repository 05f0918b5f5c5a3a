// Where this copy of Tactor lies: its folders are found from the file of libtactor, whichever program loaded it.
#pragma once

#include <filesystem>

namespace tactor {

/// The folder of libtactor.so, without symbolic links: `PREFIX/lib`, or where the system has libraries below PREFIX.
const std::filesystem::path& library_folder();

/// The folder that bin, lib and share/tactor are in; where Tactor was built, that of the build. An installation may be
/// moved as a whole.
const std::filesystem::path& installation_prefix();

}  // namespace tactor
