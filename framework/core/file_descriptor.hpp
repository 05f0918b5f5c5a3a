// An open file that is closed with its owner.
#pragma once

#include <cstddef>
#include <utility>

namespace tactor {

class FileDescriptor {
 public:
  FileDescriptor() = default;
  /// Owns `number`; a negative one stands for no file.
  explicit FileDescriptor(int number) : number_(number) {}
  ~FileDescriptor() { static_cast<void>(close()); }
  FileDescriptor(FileDescriptor&& other) noexcept : number_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    if (this != &other) {
      static_cast<void>(close());
      number_ = other.release();
    }
    return *this;
  }

  [[nodiscard]] explicit operator bool() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] int release() { return std::exchange(number_, -1); }
  /// False, with errno, where what was written could not be kept.
  [[nodiscard]] bool close();

  /// Reads `size` bytes; false at the end of the file (errno is 0) and on an error (errno tells).
  [[nodiscard]] bool read_all(void* data, std::size_t size) const;
  /// False, with errno, where not all was written.
  [[nodiscard]] bool write_all(const void* data, std::size_t size) const;

 private:
  int number_ = -1;
};

}  // namespace tactor
