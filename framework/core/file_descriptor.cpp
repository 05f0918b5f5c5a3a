#include "framework/core/file_descriptor.hpp"

#include <unistd.h>

#include <cerrno>

namespace tactor {

bool FileDescriptor::close() {
  return number_ < 0 || ::close(release()) == 0;
}

bool FileDescriptor::read_all(void* data, std::size_t size) const {
  auto* at = static_cast<char*>(data);
  errno = 0;
  while (size > 0) {
    const ssize_t n = ::read(number_, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool FileDescriptor::write_all(const void* data, std::size_t size) const {
  const auto* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::write(number_, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    at += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace tactor
