// `tactor bundle`: program, libraries and the files of studies as one archive, for machines without an installation.
#pragma once

#include <filesystem>
#include <vector>

namespace tactor {

struct BundleRequest {
  std::vector<std::filesystem::path> studies;  ///< study files
  std::filesystem::path out;                   ///< NAME.tar.gz
  bool overwrite = false;
};

/// Writes the archive. Unpacked anywhere it is a folder NAME with the command NAME/tactor and the studies with all that
/// they read in NAME/files. Of the node libraries it has those that the studies load. Of the C library it takes none:
/// the machine must have one that is as new. Throws InputError where a file names another by a path that does not hold
/// elsewhere, RunError where the disk or `tar` refuses.
void write_bundle(const BundleRequest& request);

}  // namespace tactor
