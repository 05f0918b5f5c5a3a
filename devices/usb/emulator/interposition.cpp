#include "devices/usb/emulator/interposition.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>

namespace tactor {

namespace {

struct Slot {
  std::atomic<UsbfsNode*> node{nullptr};
  std::atomic<int> fd{-1};
};
std::array<Slot, 8> slots;  // zero-initialised before any constructor runs
std::atomic<const char*> later_path{nullptr};
std::atomic<UsbfsNode* (*)()> later_make{nullptr};

/// The function of that name that stands behind ours.
template <class F>
F behind(std::atomic<F>& known, const char* name) {
  F f = known.load(std::memory_order_relaxed);
  if (f == nullptr) {
    f = reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
    if (f == nullptr) abort();
    known.store(f, std::memory_order_relaxed);
  }
  return f;
}

UsbfsNode* node_of(int fd) {
  if (fd < 0) return nullptr;
  for (Slot& slot : slots) {
    if (slot.fd.load(std::memory_order_acquire) == fd) return slot.node.load(std::memory_order_acquire);
  }
  return nullptr;
}

Slot* slot_of(const char* path) {
  const char* later = later_path.load(std::memory_order_acquire);
  if (later != nullptr && path != nullptr && std::strcmp(later, path) == 0 &&
      later_path.compare_exchange_strong(later, nullptr)) {
    interpose(*later_make.load()());
  }
  for (Slot& slot : slots) {
    const UsbfsNode* node = slot.node.load(std::memory_order_acquire);
    if (node != nullptr && path != nullptr && node->path() == path) return &slot;
  }
  return nullptr;
}

/// What a call of ours returns: errno is set where the node's answer is one.
template <class T>
T answer(T result) {
  if (result >= 0) return result;
  errno = static_cast<int>(-result);
  return -1;
}

int open_node(Slot& slot) {
  const int fd = slot.node.load()->open();
  if (fd >= 0) slot.fd.store(fd, std::memory_order_release);
  return answer(fd);
}

}  // namespace

void interpose(UsbfsNode& node) {
  for (Slot& slot : slots) {
    UsbfsNode* none = nullptr;
    if (slot.node.compare_exchange_strong(none, &node)) return;
  }
  abort();
}

void withdraw(UsbfsNode& node) {
  for (Slot& slot : slots) {
    if (slot.node.load() != &node) continue;
    slot.fd.store(-1);
    slot.node.store(nullptr);
  }
}

void interpose_when_opened(const char* path, UsbfsNode* (*make)()) {
  later_make.store(make);
  later_path.store(path, std::memory_order_release);
}

}  // namespace tactor

namespace {

using tactor::answer;
using tactor::behind;
using tactor::node_of;
using tactor::open_node;
using tactor::slot_of;

using OpenCall = int (*)(const char*, int, ...);
using CheckedOpenCall = int (*)(const char*, int);
using IoctlCall = int (*)(int, unsigned long, ...);
using ReadCall = ssize_t (*)(int, void*, size_t);
using SeekCall = off_t (*)(int, off_t, int);
using CloseCall = int (*)(int);
std::atomic<OpenCall> real_open, real_open64;
std::atomic<CheckedOpenCall> real_checked_open, real_checked_open64;
std::atomic<IoctlCall> real_ioctl;
std::atomic<ReadCall> real_read;
std::atomic<SeekCall> real_seek, real_seek64;
std::atomic<CloseCall> real_close;

}  // namespace

// The prototypes of the C library are not repeated here: its headers give some of them attributes or an inline body
// that a definition would contradict.
#define TACTOR_IN_FRONT extern "C" __attribute__((visibility("default")))

TACTOR_IN_FRONT int open(const char* path, int flags, ...) {
  if (auto* slot = slot_of(path)) return open_node(*slot);
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  return behind(real_open, "open")(path, flags, mode);
}

TACTOR_IN_FRONT int open64(const char* path, int flags, ...) {
  if (auto* slot = slot_of(path)) return open_node(*slot);
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  return behind(real_open64, "open64")(path, flags, mode);
}

// What a fortified caller of open is compiled to.
TACTOR_IN_FRONT int __open_2(const char* path, int flags) {  // NOLINT(bugprone-reserved-identifier)
  if (auto* slot = slot_of(path)) return open_node(*slot);
  return behind(real_checked_open, "__open_2")(path, flags);
}

TACTOR_IN_FRONT int __open64_2(const char* path, int flags) {  // NOLINT(bugprone-reserved-identifier)
  if (auto* slot = slot_of(path)) return open_node(*slot);
  return behind(real_checked_open64, "__open64_2")(path, flags);
}

TACTOR_IN_FRONT int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (auto* node = node_of(fd)) return answer(node->ioctl(request, argument));
  return behind(real_ioctl, "ioctl")(fd, request, argument);
}

TACTOR_IN_FRONT ssize_t read(int fd, void* buffer, size_t size) {
  if (auto* node = node_of(fd)) return answer(node->read(buffer, size));
  return behind(real_read, "read")(fd, buffer, size);
}

TACTOR_IN_FRONT off_t lseek(int fd, off_t offset, int whence) noexcept {
  if (auto* node = node_of(fd)) return answer(node->seek(offset, whence));
  return behind(real_seek, "lseek")(fd, offset, whence);
}

TACTOR_IN_FRONT off64_t lseek64(int fd, off64_t offset, int whence) noexcept {
  if (auto* node = node_of(fd)) return answer(node->seek(offset, whence));
  return behind(real_seek64, "lseek64")(fd, offset, whence);
}

TACTOR_IN_FRONT int close(int fd) {
  for (auto& slot : tactor::slots) {
    int expected = fd;
    if (fd < 0 || !slot.fd.compare_exchange_strong(expected, -1)) continue;
    slot.node.load()->close();
    return 0;
  }
  return behind(real_close, "close")(fd);
}
