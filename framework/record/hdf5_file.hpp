// Opens files through HDF5, also where the file system has no locks.
#pragma once

#include <fcntl.h>

#include <filesystem>

#include "framework/core/file_descriptor.hpp"
#include "framework/core/write_lock.hpp"
#include "framework/record/hdf5_handle.hpp"

namespace tactor {

/// What HDF5's own lock on a file would meet; `none` also where the file cannot be read.
inline LockAnswer hdf5_lock_of(const std::filesystem::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  return file ? ask_for_lock(file.number(), LockKind::shared) : LockAnswer::none;
}

/// `open(access)`. HDF5 refuses every file of a file system without locks, so there it is told to do without.
template <class Open>
Handle open_hdf5(const std::filesystem::path& path, const Handle& access, const Open& open) {
  Handle file(open(access.get()), H5Fclose);
  if (file || hdf5_lock_of(path) != LockAnswer::none) return file;
  if (H5Pset_file_locking(access.get(), false, true) < 0) return file;
  return Handle(open(access.get()), H5Fclose);
}

inline Handle usual_access() {
  return Handle(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
}

inline Handle create_hdf5(const std::filesystem::path& path, const Handle& access, hid_t creation = H5P_DEFAULT) {
  return open_hdf5(path, access, [&](hid_t how) { return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, how); });
}

inline Handle open_hdf5(const std::filesystem::path& path, unsigned flags, const Handle& access) {
  return open_hdf5(path, access, [&](hid_t how) { return H5Fopen(path.c_str(), flags, how); });
}

}  // namespace tactor
