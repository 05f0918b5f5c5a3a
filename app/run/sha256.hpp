// SHA-256 of files, as other programs print it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tactor {

/// SHA-256 of the bytes, as 64 hexadecimal digits.
std::string sha256(std::string_view bytes);

/// The same of a file's bytes; `missing` if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

/// The same of each of these files, in their order. They are libraries, which are large and seldom change: the hashes
/// are kept in the cache while no file's size, inode or time of change differs.
std::vector<std::string> sha256_of_libraries(const std::vector<std::filesystem::path>& files,
                                             const std::filesystem::path& cache_folder);

}  // namespace tactor
