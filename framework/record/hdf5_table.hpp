// Writes a table as HDF5.
#pragma once

#include <filesystem>

#include "framework/record/table.hpp"

namespace tactor {

/// One dataset a column, by its name with `/` as `|`, and the attributes at the root; nothing in the file depends on
/// when it was written. A file that was there is replaced. Throws RunError, with the path, where the disk refuses.
void write_hdf5_table(const std::filesystem::path& path, const TableFile& table);

}  // namespace tactor
