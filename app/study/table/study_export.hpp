// The table of a study as HDF5.
#pragma once

#include <filesystem>

#include "app/study/table/study.hpp"

namespace tactor {

/// A row a run, in the order of study_csv, metrics and run times; nothing where this build has no HDF5. Throws RunError
/// where the disk refuses.
void write_study_hdf5(const std::filesystem::path& path, const Study& study);

}  // namespace tactor
