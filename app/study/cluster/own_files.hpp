// Files and folders of a study on a cluster, which count only where nobody but their user can have written them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tactor {

/// All bytes of a file; nothing if there is none. Throws InputError if somebody else may have written the file or its
/// folder. It throws the same if the file is no regular file (see KeptFolder).
std::optional<std::string> own_bytes(const std::filesystem::path& file);

/// Throws the same where a folder that is there is not of this user alone, or where everybody may put another one in
/// its place, because its files name programs that are started.
void demand_own(const std::filesystem::path& folder);

/// Makes a folder that only this user may write, whatever new files are given by default; one that is there stays.
void make_own_folder(const std::filesystem::path& folder);

}  // namespace tactor
