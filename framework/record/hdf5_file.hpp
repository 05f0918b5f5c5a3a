// Opens files through HDF5, also where the file system has no locks.
#pragma once

#include <fcntl.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "framework/core/file_descriptor.hpp"
#include "framework/core/write_lock.hpp"
#include "framework/record/hdf5_handle.hpp"

namespace tactor {

/// What HDF5's own lock on a file would meet: `shared` for a reader, `whole` for a writer. `none` also where the file
/// cannot be read.
inline LockAnswer hdf5_lock_of(const std::filesystem::path& path, LockKind kind) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  return file ? ask_for_lock(file.number(), kind) : LockAnswer::none;
}

/// `open(access)`. HDF5 refuses every file of a file system without locks, so there it is told to do without.
template <class Open>
Handle open_hdf5(const std::filesystem::path& path, const Handle& access, const Open& open) {
  Handle file(open(access.get()), H5Fclose);
  if (file || hdf5_lock_of(path, LockKind::shared) != LockAnswer::none) return file;
  if (H5Pset_file_locking(access.get(), false, true) < 0) return file;
  return Handle(open(access.get()), H5Fclose);
}

inline Handle usual_access() {
  return Handle(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
}

/// HDF5 creates no file under the lock of a reader, and a program may look at the file in this moment. So this asks
/// again for a second, and once more where the reader has gone meanwhile.
inline Handle create_hdf5(const std::filesystem::path& path, const Handle& access, hid_t creation = H5P_DEFAULT) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  for (bool again = true;; again = hdf5_lock_of(path, LockKind::whole) == LockAnswer::busy) {
    Handle file =
        open_hdf5(path, access, [&](hid_t how) { return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, how); });
    if (file || !again || std::chrono::steady_clock::now() > give_up) return file;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

inline Handle open_hdf5(const std::filesystem::path& path, unsigned flags, const Handle& access) {
  return open_hdf5(path, access, [&](hid_t how) { return H5Fopen(path.c_str(), flags, how); });
}

}  // namespace tactor
