#include "devices/usb/emulator/usbfs_node.hpp"

#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace tactor {

namespace {

/// An eventfd whose counter is as high as it can be has no room for a further event, so it cannot be written to.
constexpr std::uint64_t full = 0xffff'ffff'ffff'fffeULL;
constexpr int full_speed = 2;  // enum usb_device_speed of the kernel

std::uint16_t word(const std::uint8_t* bytes) {
  return static_cast<std::uint16_t>(bytes[0] | (bytes[1] << 8U));
}

}  // namespace

UsbfsNode::UsbfsNode(std::string path, UsbFunction& function, std::uint32_t address)
    : path_(std::move(path)), function_(function), address_(address) {}

UsbfsNode::~UsbfsNode() {
  if (fd_ >= 0) syscall(SYS_close, fd_);
}

bool UsbfsNode::plugged() const {
  const std::lock_guard lock(mutex_);
  return plugged_;
}

bool UsbfsNode::is_open() const {
  const std::lock_guard lock(mutex_);
  return fd_ >= 0;
}

bool UsbfsNode::is_sending() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(pending_.begin(), pending_.end(),
                     [](const usbdevfs_urb* u) { return (u->endpoint & 0x80U) == 0; });
}

int UsbfsNode::openings() const {
  const std::lock_guard lock(mutex_);
  return openings_;
}

int UsbfsNode::open() {
  const std::lock_guard lock(mutex_);
  if (!plugged_) return -ENOENT;
  if (fd_ >= 0) return -EBUSY;
  fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (fd_ < 0) return -errno;
  ++openings_;
  gone_ = false;
  shows_ready_ = true;  // as an eventfd is that was just made
  position_ = 0;
  halted_.clear();
  descriptors_ = function_.descriptors();
  show_ready();
  function_.opened();
  return fd_;
}

void UsbfsNode::close() {
  const std::lock_guard lock(mutex_);
  if (fd_ < 0) return;
  syscall(SYS_close, fd_);
  fd_ = -1;
  pending_.clear();
  finished_.clear();
  function_.closed();
}

/// Makes the descriptor writable where something waits to be reaped.
void UsbfsNode::show_ready() {
  if (fd_ < 0 || shows_ready_ == !finished_.empty()) return;
  shows_ready_ = !finished_.empty();
  // The calls go round the C library, because `read` there leads back here.
  std::uint64_t drained = 0;
  if (shows_ready_) {
    static_cast<void>(syscall(SYS_read, fd_, &drained, sizeof drained));
  } else {
    static_cast<void>(syscall(SYS_write, fd_, &full, sizeof full));
  }
}

void UsbfsNode::finish(usbdevfs_urb& urb, int status) {
  urb.status = status;
  finished_.push_back(&urb);
}

bool UsbfsNode::answer_control(usbdevfs_urb& urb) {
  auto* bytes = static_cast<std::uint8_t*>(urb.buffer);
  if (urb.buffer_length < 8) return false;
  const UsbSetup setup{bytes[0], bytes[1], word(bytes + 2), word(bytes + 4), word(bytes + 6)};
  const std::size_t room = std::min<std::size_t>(setup.length, static_cast<std::size_t>(urb.buffer_length) - 8);
  const auto went = function_.control(setup, {bytes + 8, room});
  urb.actual_length = went ? static_cast<int>(*went) : 0;
  finish(urb, went ? 0 : -EPIPE);
  return true;
}

/// Hands over what a transfer of that type brings to the device; false where it is another.
bool UsbfsNode::take_out(usbdevfs_urb& urb, unsigned char type) {
  if (urb.type != type || (urb.endpoint & 0x80U) != 0) return false;
  const auto* bytes = static_cast<const std::uint8_t*>(urb.buffer);
  function_.out(urb.endpoint, {bytes, static_cast<std::size_t>(urb.buffer_length)});
  urb.actual_length = urb.buffer_length;
  finish(urb, 0);
  return true;
}

bool UsbfsNode::answer_in(usbdevfs_urb& urb) {
  const auto bytes = function_.in(urb.endpoint);
  if (!bytes) return false;
  const std::size_t n = std::min(bytes->size(), static_cast<std::size_t>(urb.buffer_length));
  std::copy_n(bytes->begin(), n, static_cast<std::uint8_t*>(urb.buffer));
  urb.actual_length = static_cast<int>(n);
  finish(urb, bytes->size() > n ? -EOVERFLOW : 0);
  return true;
}

int UsbfsNode::submit(usbdevfs_urb& urb) {
  urb.actual_length = 0;
  if (urb.buffer_length < 0) return -EINVAL;
  switch (urb.type) {
    case USBDEVFS_URB_TYPE_CONTROL:
      if (!answer_control(urb)) return -EINVAL;
      show_ready();
      return 0;
    case USBDEVFS_URB_TYPE_BULK:
    case USBDEVFS_URB_TYPE_INTERRUPT:
      pending_.push_back(&urb);
      return 0;
    default:
      return -EINVAL;
  }
}

void UsbfsNode::frame(double dt) {
  const std::lock_guard lock(mutex_);
  if (fd_ < 0 || gone_) return;
  function_.tick(dt);
  for (Halt& halt : halted_) tell(halt);
  std::deque<usbdevfs_urb*> still;
  // Bulk transfers follow one another within a frame, so what is sent can be answered in it.
  for (usbdevfs_urb* urb : pending_) {
    if (is_halted(urb->endpoint) || !take_out(*urb, USBDEVFS_URB_TYPE_BULK)) still.push_back(urb);
  }
  pending_ = std::move(still);
  still.clear();
  std::vector<std::uint8_t> answered;  // interrupt endpoints that have had their transfer of this frame
  for (usbdevfs_urb* urb : pending_) {
    if (is_halted(urb->endpoint)) {
      still.push_back(urb);
      continue;
    }
    if (take_out(*urb, USBDEVFS_URB_TYPE_INTERRUPT)) continue;
    const bool interrupt = urb->type == USBDEVFS_URB_TYPE_INTERRUPT;
    const bool done = std::find(answered.begin(), answered.end(), urb->endpoint) != answered.end();
    if (done || !answer_in(*urb)) {
      still.push_back(urb);
    } else if (interrupt) {
      answered.push_back(urb->endpoint);
    }
  }
  pending_ = std::move(still);
  show_ready();
}

bool UsbfsNode::is_halted(std::uint8_t endpoint) const {
  return std::any_of(halted_.begin(), halted_.end(), [&](const Halt& h) { return h.endpoint == endpoint; });
}

void UsbfsNode::halt(std::uint8_t endpoint) {
  const std::lock_guard lock(mutex_);
  if (!is_halted(endpoint)) halted_.push_back({endpoint, false});
}

void UsbfsNode::tell(Halt& halt) {
  const auto first = std::find_if(pending_.begin(), pending_.end(),
                                  [&](const usbdevfs_urb* urb) { return urb->endpoint == halt.endpoint; });
  if (halt.told || first == pending_.end()) return;
  halt.told = true;
  finish(**first, -EPIPE);
  pending_.erase(first);
}

int UsbfsNode::set_free(std::uint8_t endpoint) {
  const auto queued = [&](const usbdevfs_urb* urb) { return urb->endpoint == endpoint; };
  if (std::any_of(pending_.begin(), pending_.end(), queued)) return -EBUSY;
  std::erase_if(halted_, [&](const Halt& halt) { return halt.endpoint == endpoint; });
  return 0;
}

int UsbfsNode::discard(const usbdevfs_urb* urb) {
  const auto found = std::find(pending_.begin(), pending_.end(), urb);
  if (found == pending_.end()) return -EINVAL;
  finish(**found, -ENOENT);
  pending_.erase(found);
  show_ready();
  return 0;
}

int UsbfsNode::reap(usbdevfs_urb** urb) {
  if (finished_.empty()) return gone_ ? -ENODEV : -EAGAIN;
  *urb = finished_.front();
  finished_.pop_front();
  show_ready();
  return 0;
}

int UsbfsNode::control(usbdevfs_ctrltransfer& transfer) {
  const UsbSetup setup{transfer.bRequestType, transfer.bRequest, transfer.wValue, transfer.wIndex, transfer.wLength};
  const auto went = function_.control(setup, {static_cast<std::uint8_t*>(transfer.data), transfer.wLength});
  return went ? static_cast<int>(*went) : -EPIPE;
}

int UsbfsNode::ioctl(unsigned long request, void* argument) {
  const std::lock_guard lock(mutex_);
  if (fd_ < 0) return -EBADF;
  // What is finished may be reaped after the device has gone; all else fails.
  if (request == USBDEVFS_REAPURBNDELAY) return reap(static_cast<usbdevfs_urb**>(argument));
  if (gone_) return -ENODEV;
  switch (request) {
    case USBDEVFS_SUBMITURB:
      return submit(*static_cast<usbdevfs_urb*>(argument));
    case USBDEVFS_DISCARDURB:
      return discard(static_cast<const usbdevfs_urb*>(argument));
    case USBDEVFS_CONTROL:
      return control(*static_cast<usbdevfs_ctrltransfer*>(argument));
    case USBDEVFS_CONNECTINFO: {
      auto* info = static_cast<usbdevfs_connectinfo*>(argument);
      info->devnum = address_;
      info->slow = 0;
      return 0;
    }
    case USBDEVFS_GET_CAPABILITIES:
      *static_cast<std::uint32_t*>(argument) = USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      return 0;
    case USBDEVFS_GET_SPEED:
      return full_speed;
    case USBDEVFS_GETDRIVER:
      return -ENODATA;  // no driver of the kernel has it
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_CLEAR_HALT:
      return set_free(static_cast<std::uint8_t>(*static_cast<const unsigned*>(argument)));
    case USBDEVFS_RESET:
      return 0;
    case USBDEVFS_IOCTL:
      return -ENODATA;  // of a driver of the kernel
    default:
      return -ENOTTY;
  }
}

ssize_t UsbfsNode::read(void* buffer, std::size_t size) {
  const std::lock_guard lock(mutex_);
  if (fd_ < 0) return -EBADF;
  if (gone_) return -ENODEV;
  const std::size_t n = std::min(size, descriptors_.size() - std::min(position_, descriptors_.size()));
  std::memcpy(buffer, descriptors_.data() + position_, n);
  position_ += n;
  return static_cast<ssize_t>(n);
}

off_t UsbfsNode::seek(off_t offset, int whence) {
  const std::lock_guard lock(mutex_);
  if (whence == SEEK_CUR) offset += static_cast<off_t>(position_);
  if ((whence != SEEK_SET && whence != SEEK_CUR) || offset < 0) return -EINVAL;
  position_ = std::min(static_cast<std::size_t>(offset), descriptors_.size());
  return static_cast<off_t>(position_);
}

void UsbfsNode::unplug() {
  const std::lock_guard lock(mutex_);
  plugged_ = false;
  if (fd_ < 0) return;
  gone_ = true;
  while (!pending_.empty()) {
    finish(*pending_.front(), -ESHUTDOWN);
    pending_.pop_front();
  }
  show_ready();
}

void UsbfsNode::plug() {
  const std::lock_guard lock(mutex_);
  if (plugged_) return;
  plugged_ = true;
  address_ = address_ % 127 + 1;
}

}  // namespace tactor
