// An emulated /dev/bus/usb node: answers the protocol that libusb speaks with the kernel's usbfs.
#pragma once

#include <linux/usbdevice_fs.h>
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "devices/usb/emulator/usb_function.hpp"

namespace tactor {

/// One USB device as a file. What stands in front of the C library's open, ioctl, read, lseek and close (see
/// interposition.hpp) passes on to it what concerns its path or its descriptor.
///
/// The descriptor is an eventfd: it can be written to, as libusb's poll asks, exactly while a finished transfer waits
/// to be reaped. One open descriptor at a time. Thread-safe.
class UsbfsNode {
 public:
  /// `function` outlives the node; `address` is that on the bus until it is plugged in anew.
  UsbfsNode(std::string path, UsbFunction& function, std::uint32_t address = 2);
  ~UsbfsNode();
  UsbfsNode(const UsbfsNode&) = delete;
  UsbfsNode& operator=(const UsbfsNode&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

  /// Moves time on by a frame of USB, a millisecond: hands over what was sent, and answers one transfer of each
  /// interrupt IN endpoint and all that can be answered of bulk ones.
  /// `dt` in s, that passed since the last one.
  void frame(double dt = 1e-3);
  /// The endpoint stalls: its next transfer ends with EPIPE, and nothing more happens there until
  /// USBDEVFS_CLEAR_HALT, which is refused with EBUSY while other transfers are queued there.
  void halt(std::uint8_t endpoint);
  /// The cable is pulled: transfers end with ESHUTDOWN, all else fails with ENODEV until the descriptor is closed, and
  /// the path is not there until `plug`.
  void unplug();
  void plug();
  [[nodiscard]] bool plugged() const;
  [[nodiscard]] bool is_open() const;
  /// Whether something that was sent waits for the next frame.
  [[nodiscard]] bool is_sending() const;
  /// How often it has been opened.
  [[nodiscard]] int openings() const;

  /// Does something with the function while nothing else does.
  template <class F>
  auto locked(F&& work) {
    const std::lock_guard lock(mutex_);
    return work();
  }

  // The system calls; they return what the call does, or a negative errno.
  int open();
  int ioctl(unsigned long request, void* argument);
  ssize_t read(void* buffer, std::size_t size);
  off_t seek(off_t offset, int whence);
  void close();

 private:
  struct Halt {
    std::uint8_t endpoint;
    bool told;  // to a transfer
  };

  int submit(usbdevfs_urb& urb);
  int discard(const usbdevfs_urb* urb);
  int reap(usbdevfs_urb** urb);
  int control(usbdevfs_ctrltransfer& transfer);
  bool answer_control(usbdevfs_urb& urb);
  bool take_out(usbdevfs_urb& urb, unsigned char type);
  bool answer_in(usbdevfs_urb& urb);
  [[nodiscard]] bool is_halted(std::uint8_t endpoint) const;
  void tell(Halt& halt);
  int set_free(std::uint8_t endpoint);
  void finish(usbdevfs_urb& urb, int status);
  void show_ready();

  std::string path_;
  UsbFunction& function_;
  mutable std::mutex mutex_;
  int fd_ = -1;
  int openings_ = 0;
  bool plugged_ = true;
  std::uint32_t address_;  // on the bus; another one each time it is plugged in
  bool gone_ = false;      // the open descriptor belongs to a device that was unplugged
  bool shows_ready_ = true;
  std::vector<Halt> halted_;
  std::vector<std::uint8_t> descriptors_;
  std::size_t position_ = 0;
  std::deque<usbdevfs_urb*> pending_, finished_;
};

}  // namespace tactor
