#include "devices/usb/usb_port.hpp"

#include <fcntl.h>
#include <libusb-1.0/libusb.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <utility>

#include "devices/hardware/claim.hpp"
#include "devices/hardware/device_descriptors.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// How long the end of cancelled transfers is waited for; the kernel needs a frame.
constexpr int cancel_rounds = 200;

void LIBUSB_CALL descriptor_added(int descriptor, short /*events*/, void* /*user*/) {
  keep_from_children(descriptor);
}
void LIBUSB_CALL descriptor_removed(int descriptor, void* /*user*/) {
  forget_descriptor(descriptor);
}

int open_handle(libusb_device* device, libusb_device_handle** handle) {
  const NoFork until_kept;
  return libusb_open(device, handle);
}
void close_handle(libusb_device_handle* handle) {
  const NoFork until_closed;
  libusb_close(handle);
}

const char* words(UsbResult result) {
  switch (result) {
    case UsbResult::timeout:
      return "a transfer timed out";
    case UsbResult::stalled:
      return "an endpoint has stalled";
    case UsbResult::overflow:
      return "a report is longer than a packet";
    case UsbResult::disconnected:
      return "the device has been unplugged";
    default:
      return "a transfer has failed";
  }
}

UsbResult result_of(int code) {
  switch (code) {
    case LIBUSB_ERROR_TIMEOUT:
      return UsbResult::timeout;
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return UsbResult::disconnected;
    case LIBUSB_ERROR_PIPE:
      return UsbResult::stalled;
    case LIBUSB_ERROR_OVERFLOW:
      return UsbResult::overflow;
    default:
      return code >= 0 ? UsbResult::ok : UsbResult::failed;
  }
}

UsbResult result_of(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
    case LIBUSB_TRANSFER_CANCELLED:
      return UsbResult::ok;
    case LIBUSB_TRANSFER_TIMED_OUT:
      return UsbResult::timeout;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return UsbResult::disconnected;
    case LIBUSB_TRANSFER_STALL:
      return UsbResult::stalled;
    case LIBUSB_TRANSFER_OVERFLOW:
      return UsbResult::overflow;
    default:
      return UsbResult::failed;
  }
}

std::string hex(std::uint16_t vendor, std::uint16_t product) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x:%04x", vendor, product);
  return text;
}

std::string path_of(libusb_device* device) {
  std::array<std::uint8_t, 8> ports{};
  const int n = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  if (n <= 0) return {};
  std::string path = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < n; ++i) path += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  return path;
}

std::string string_of(libusb_device_handle* handle, std::uint8_t index) {
  std::array<unsigned char, 256> text{};
  if (index == 0) return {};
  const int n = libusb_get_string_descriptor_ascii(handle, index, text.data(), static_cast<int>(text.size()));
  return n > 0 ? std::string(text.begin(), text.begin() + n) : std::string();
}

std::string first_line(const char* file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// How long the machine has slept since its boot, ms, to the nearest 10. A device may have lost its power in that time
/// although the kernel gives it its old place and address again.
std::int64_t slept_ms() {
  const auto read_ns = [](clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  };
  std::int64_t slept = 0;
  for (int i = 0; i < 100; ++i) {
    const std::int64_t before = read_ns(CLOCK_MONOTONIC);
    slept = read_ns(CLOCK_BOOTTIME) - before;
    if (read_ns(CLOCK_MONOTONIC) - before < 1'000'000) break;  // nothing came in between
  }
  return (slept + 5'000'000) / 10'000'000 * 10;
}

/// The boot, the sleep since then, the place on the bus, the address, which counts up with each plugging in, and the
/// numbers of the files that the kernel makes anew each time.
std::string identity_of(const UsbDeviceInfo& info, const std::filesystem::path& file) {
  std::string text = first_line("/proc/sys/kernel/random/boot_id") + "/" + std::to_string(slept_ms()) + "/" +
                     std::to_string(info.bus) + "/" + info.path + "/" + std::to_string(info.address) + "/" +
                     info.serial;
  struct stat status {};
  const std::string folder = "/sys/bus/usb/devices/" + info.path;
  if (!info.path.empty() && stat(folder.c_str(), &status) == 0) text += "/" + std::to_string(status.st_ino);
  if (!file.empty() && stat(file.c_str(), &status) == 0) {
    text += "/" + file.string() + "/" + std::to_string(status.st_ino) + "/" + std::to_string(status.st_ctim.tv_sec) +
            "." + std::to_string(status.st_ctim.tv_nsec);
  }
  return text;
}

/// What a device tells without being opened.
UsbDeviceInfo info_of(libusb_device* device) {
  UsbDeviceInfo info;
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(device, &descriptor) != 0) return info;
  info.vendor = descriptor.idVendor;
  info.product = descriptor.idProduct;
  info.bus = libusb_get_bus_number(device);
  info.address = libusb_get_device_address(device);
  info.path = path_of(device);
  return info;
}

/// What an opened device tells of itself, by requests to it.
void read_texts(UsbDeviceInfo& info, libusb_device_handle* handle) {
  info.may_open = true;
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(libusb_get_device(handle), &descriptor) != 0) return;
  info.maker = string_of(handle, descriptor.iManufacturer);
  info.name = string_of(handle, descriptor.iProduct);
  info.serial = string_of(handle, descriptor.iSerialNumber);
}

/// The devices on the bus, given back with the list.
class DeviceList {
 public:
  explicit DeviceList(libusb_context* context) : size_(libusb_get_device_list(context, &devices_)) {}
  ~DeviceList() {
    if (size_ >= 0) libusb_free_device_list(devices_, 1);
  }
  DeviceList(const DeviceList&) = delete;
  DeviceList& operator=(const DeviceList&) = delete;
  [[nodiscard]] std::span<libusb_device* const> all() const {
    return {devices_, static_cast<std::size_t>(std::max<ssize_t>(size_, 0))};
  }

 private:
  libusb_device** devices_ = nullptr;
  ssize_t size_;
};

}  // namespace

LinkFailure failure_of(UsbResult result) {
  const bool gone = result == UsbResult::disconnected;
  return {gone ? LinkError::reset : LinkError::protocol, words(result), gone};
}

UsbSelector selector_of(std::uint16_t vendor, std::uint16_t product, const UsbChoice& choice) {
  UsbSelector selector{vendor, product, choice.serial, choice.file};
  const char* file = std::getenv("TACTOR_USB_FILE");
  if (selector.file.empty() && file != nullptr) selector.file = file;
  return selector;
}

/// The handle and its transfers, which libusb knows by their addresses.
struct UsbPort::Impl {
  static constexpr std::size_t readers = 2;  // one is filled by the device while the other is looked at

  struct Reader {
    libusb_transfer* transfer = nullptr;
    std::vector<unsigned char> buffer;
    bool busy = false;
  };

  libusb_context* context = nullptr;
  libusb_device_handle* handle = nullptr;
  int own_fd = -1;  // of a device that was opened by its file
  std::filesystem::path file;
  Claim claim;
  int claimed = -1;
  UsbListener* listener = nullptr;
  std::array<Reader, readers> in;
  libusb_transfer* out = nullptr;
  std::vector<unsigned char> out_buffer;
  bool out_busy = false;
  bool ending = false;
  std::uint8_t halted = 0;          // endpoint that has stalled; 0: none
  UsbResult worst = UsbResult::ok;  // since the last wait
  int ended = 0;                    // told to libusb's event loop: something has come

  void note(UsbResult result) {
    if (result != UsbResult::ok && worst != UsbResult::disconnected) worst = result;
    ended = 1;
  }
  /// The device's file, as the kernel calls it.
  [[nodiscard]] std::string file_name() const {
    if (!file.empty()) return file.string();
    libusb_device* device = libusb_get_device(handle);
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "/dev/bus/usb/%03d/%03d", libusb_get_bus_number(device),
                  libusb_get_device_address(device));
    return text.data();
  }
  /// What nobody else may claim; empty where the file is none of the kernel's devices, as in an emulation, which every
  /// process has for itself.
  [[nodiscard]] std::string claim_name(int interface) const {
    struct stat status {};
    if (stat(file_name().c_str(), &status) != 0 || !S_ISCHR(status.st_mode)) return {};
    return "usb " + std::to_string(major(status.st_rdev)) + ":" + std::to_string(minor(status.st_rdev)) +
           " interface " + std::to_string(interface);
  }
  /// True where one of them still has to end.
  bool cancel_readers() {
    bool any = false;
    for (Reader& reader : in) {
      if (reader.busy) libusb_cancel_transfer(reader.transfer);
      any = any || reader.busy;
    }
    return any;
  }
  void submit(Reader& reader) {
    const int code = libusb_submit_transfer(reader.transfer);
    reader.busy = code == 0;
    if (code != 0) note(result_of(code));
  }
  [[nodiscard]] bool any_busy() const {
    return out_busy || std::any_of(in.begin(), in.end(), [](const Reader& r) { return r.busy; });
  }

  static void LIBUSB_CALL in_ended(libusb_transfer* transfer) {
    auto& self = *static_cast<Impl*>(transfer->user_data);
    for (Reader& reader : self.in) {
      if (reader.transfer != transfer) continue;
      reader.busy = false;
      if (self.ending || transfer->status == LIBUSB_TRANSFER_CANCELLED) return;
      const UsbResult result = result_of(transfer->status);
      self.note(result);
      if (result == UsbResult::disconnected) return;
      if (result == UsbResult::stalled) {
        self.halted = transfer->endpoint;
        return;
      }
      if (result == UsbResult::ok) {
        const auto n = static_cast<std::size_t>(std::max(transfer->actual_length, 0));
        self.listener->received({transfer->buffer, std::min(n, reader.buffer.size())});
      }
      self.submit(reader);
    }
  }
  static void LIBUSB_CALL out_ended(libusb_transfer* transfer) {
    auto& self = *static_cast<Impl*>(transfer->user_data);
    self.out_busy = false;
    if (self.ending) return;
    const UsbResult result = result_of(transfer->status);
    self.note(result);
    if (result == UsbResult::stalled) self.halted = transfer->endpoint;
  }
  /// A stalled endpoint takes nothing until it is told to go on, and must have nothing queued then.
  void set_free() {
    if (halted == 0) return;
    if (halted == in[0].transfer->endpoint && cancel_readers()) return;
    const int code = libusb_clear_halt(handle, std::exchange(halted, std::uint8_t{0}));
    if (code != 0) note(result_of(code));
    for (Reader& reader : in) {
      if (!reader.busy) submit(reader);
    }
  }
};

UsbPort::UsbPort(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

UsbPort::~UsbPort() {
  Impl& i = *impl_;
  i.ending = true;
  i.cancel_readers();
  // What was sent last may be the zero that must arrive: it is let through before it is called back.
  for (int round = 0; round < cancel_rounds && i.any_busy(); ++round) {
    if (round == cancel_rounds / 2 && i.out_busy) libusb_cancel_transfer(i.out);
    timeval most{0, 1000};
    libusb_handle_events_timeout_completed(i.context, &most, nullptr);
  }
  if (i.claimed >= 0) libusb_release_interface(i.handle, i.claimed);
  close_handle(i.handle);
  close_kept(i.own_fd);
  if (i.any_busy()) {
    // libusb may still write into them: they are left behind rather than given back.
    static_cast<void>(impl_.release());
    return;
  }
  for (Impl::Reader& reader : i.in) libusb_free_transfer(reader.transfer);
  libusb_free_transfer(i.out);
}

UsbResult UsbPort::control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                           std::span<std::uint8_t> data, Duration most) {
  const int code =
      libusb_control_transfer(impl_->handle, type, request, value, index, data.data(),
                              static_cast<std::uint16_t>(data.size()), static_cast<unsigned>(most.milliseconds()));
  return result_of(code);
}

std::string UsbPort::start(const UsbTransfers& transfers, UsbListener& listener) {
  Impl& i = *impl_;
  const bool interrupt = transfers.kind == UsbTransfers::Kind::interrupt;
  const char* kind = interrupt ? "interrupt" : "bulk";
  std::uint8_t in = 0, out = 0;
  std::size_t in_packet = 0;
  libusb_config_descriptor* configuration = nullptr;
  if (libusb_get_active_config_descriptor(libusb_get_device(i.handle), &configuration) != 0) {
    return "its descriptors cannot be read";
  }
  for (int n = 0; n < configuration->bNumInterfaces; ++n) {
    const libusb_interface& candidate = configuration->interface[n];
    if (candidate.num_altsetting < 1 || candidate.altsetting[0].bInterfaceNumber != transfers.interface) continue;
    const libusb_interface_descriptor& descriptor = candidate.altsetting[0];
    for (int e = 0; e < descriptor.bNumEndpoints; ++e) {
      const libusb_endpoint_descriptor& endpoint = descriptor.endpoint[e];
      const bool same_kind = (endpoint.bmAttributes & 3U) == (interrupt ? 3U : 2U);
      const bool to_host = (endpoint.bEndpointAddress & 0x80U) != 0;
      const std::uint8_t wanted = to_host ? transfers.in : transfers.out;
      std::uint8_t& found = to_host ? in : out;
      if (!same_kind || found != 0 || (wanted != 0 && wanted != endpoint.bEndpointAddress)) continue;
      found = endpoint.bEndpointAddress;
      if (to_host) in_packet = endpoint.wMaxPacketSize & 0x7ffU;
    }
  }
  libusb_free_config_descriptor(configuration);
  if (in == 0 || out == 0) {
    return std::string("interface ") + std::to_string(transfers.interface) + " has no " + kind + " endpoint " +
           (in == 0 ? "to the host" : "to the device") + ", so it is another device with the same USB numbers";
  }
  // What a packet does not fill the device may overflow: whole packets are asked for.
  std::size_t in_size = std::max<std::size_t>(transfers.in_size, 1);
  if (in_packet > 0) in_size = (in_size + in_packet - 1) / in_packet * in_packet;

  // The kernel refuses the second one too, but does not say who is the first.
  std::string why;
  if (const std::string name = i.claim_name(transfers.interface); !name.empty() && !i.claim.take(name, why)) return why;
  libusb_set_auto_detach_kernel_driver(i.handle, 1);
  const int code = libusb_claim_interface(i.handle, transfers.interface);
  if (code == LIBUSB_ERROR_BUSY) return in_use_by(users_of(i.file_name()));
  if (code != 0) return std::string("its interface cannot be claimed: ") + libusb_error_name(code);
  i.claimed = transfers.interface;
  i.listener = &listener;

  const auto fill_transfer = interrupt ? libusb_fill_interrupt_transfer : libusb_fill_bulk_transfer;
  i.out = libusb_alloc_transfer(0);
  i.out_buffer.resize(std::max<std::size_t>(transfers.out_size, 1));
  if (i.out == nullptr) return "no memory for transfers";
  fill_transfer(i.out, i.handle, out, i.out_buffer.data(), 0, &Impl::out_ended, &i, 0);
  for (Impl::Reader& reader : i.in) {
    reader.buffer.resize(in_size);
    reader.transfer = libusb_alloc_transfer(0);
    if (reader.transfer == nullptr) return "no memory for transfers";
    fill_transfer(reader.transfer, i.handle, in, reader.buffer.data(), static_cast<int>(in_size), &Impl::in_ended, &i,
                  0);
  }
  for (Impl::Reader& reader : i.in) i.submit(reader);
  return i.worst == UsbResult::ok ? "" : "its transfers cannot be started";
}

bool UsbPort::sending() const {
  return impl_->out_busy;
}

bool UsbPort::send(std::span<const std::uint8_t> bytes) {
  Impl& i = *impl_;
  TACTOR_DEMAND(i.out != nullptr && bytes.size() <= i.out_buffer.size());
  if (i.out_busy) return false;
  std::copy(bytes.begin(), bytes.end(), i.out_buffer.begin());
  i.out->length = static_cast<int>(bytes.size());
  const int code = libusb_submit_transfer(i.out);
  i.out_busy = code == 0;
  if (code != 0) i.note(result_of(code));
  return code == 0;
}

UsbResult UsbPort::wait(Duration most) {
  Impl& i = *impl_;
  if (i.worst == UsbResult::ok) {
    i.ended = 0;
    const std::int64_t us = std::max<std::int64_t>(most.ns, 0) / 1000;
    timeval time{static_cast<time_t>(us / 1'000'000), static_cast<suseconds_t>(us % 1'000'000)};
    const int code = libusb_handle_events_timeout_completed(i.context, &time, &i.ended);
    if (code != 0 && code != LIBUSB_ERROR_INTERRUPTED) i.note(result_of(code));
    i.set_free();
  }
  const UsbResult result = i.worst;
  i.worst = UsbResult::ok;
  return result;
}

UsbBus::UsbBus() {
  const NoFork until_kept;
  int code = libusb_init(&context_);
  if (code != 0) {
    // A container without the bus: devices can be opened by their files all the same.
    libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
    code = libusb_init(&context_);
  }
  if (code != 0) throw RunError(std::string("libusb cannot be used: ") + libusb_error_name(code));
  // It tells of every descriptor that it waits for, those of opened devices among them.
  libusb_set_pollfd_notifiers(context_, &descriptor_added, &descriptor_removed, nullptr);
  const libusb_pollfd** waited_for = libusb_get_pollfds(context_);
  for (const libusb_pollfd** one = waited_for; one != nullptr && *one != nullptr; ++one) keep_from_children((*one)->fd);
  libusb_free_pollfds(waited_for);
}

UsbBus::~UsbBus() {
  const NoFork until_closed;
  const libusb_pollfd** waited_for = libusb_get_pollfds(context_);
  libusb_set_pollfd_notifiers(context_, nullptr, nullptr, nullptr);
  for (const libusb_pollfd** one = waited_for; one != nullptr && *one != nullptr; ++one) {
    forget_descriptor((*one)->fd);
  }
  libusb_free_pollfds(waited_for);
  libusb_exit(context_);
}

std::vector<UsbDeviceInfo> UsbBus::devices(std::span<const UsbNumbers> kinds) const {
  const DeviceList list(context_);
  std::vector<UsbDeviceInfo> found;
  for (libusb_device* device : list.all()) {
    UsbDeviceInfo info = info_of(device);
    const auto is_this = [&](const UsbNumbers& k) { return k.vendor == info.vendor && k.product == info.product; };
    if (std::none_of(kinds.begin(), kinds.end(), is_this)) continue;
    libusb_device_handle* handle = nullptr;
    if (open_handle(device, &handle) == 0) {
      read_texts(info, handle);
      close_handle(handle);
    }
    found.push_back(std::move(info));
  }
  return found;
}

std::unique_ptr<UsbPort> UsbBus::open(const UsbSelector& selector, std::string& why) {
  auto impl = std::make_unique<UsbPort::Impl>();
  impl->context = context_;
  const std::string numbers = hex(selector.vendor, selector.product);
  if (!selector.file.empty()) {
    const NoFork until_kept;
    impl->own_fd = ::open(selector.file.c_str(), O_RDWR | O_CLOEXEC);
    keep_from_children(impl->own_fd);
    if (impl->own_fd < 0) {
      why = selector.file.string() + " cannot be opened: " + std::strerror(errno);
      return nullptr;
    }
    impl->file = selector.file;
    const int code = libusb_wrap_sys_device(context_, impl->own_fd, &impl->handle);
    if (code != 0) {
      close_kept(impl->own_fd);
      why = selector.file.string() + " is not a usable USB device: " + libusb_error_name(code);
      return nullptr;
    }
  } else {
    const DeviceList list(context_);
    why = "no device " + numbers + " on the USB; is it plugged in and powered?";
    for (libusb_device* device : list.all()) {
      libusb_device_descriptor descriptor{};
      if (libusb_get_device_descriptor(device, &descriptor) != 0) continue;
      if (descriptor.idVendor != selector.vendor || descriptor.idProduct != selector.product) continue;
      const int code = open_handle(device, &impl->handle);
      if (code != 0) {
        impl->handle = nullptr;
        why = "device " + numbers + " at " + path_of(device) +
              (code == LIBUSB_ERROR_ACCESS ? " cannot be opened by this user; `tactor doctor` says how to allow it"
                                           : std::string(" cannot be opened: ") + libusb_error_name(code));
        continue;
      }
      if (selector.serial.empty()) break;
      const std::string serial = string_of(impl->handle, descriptor.iSerialNumber);
      if (serial == selector.serial) break;
      why = "device " + numbers + " has serial number \"" + serial + "\", not \"" + selector.serial + "\"";
      close_handle(impl->handle);
      impl->handle = nullptr;
    }
    if (impl->handle == nullptr) return nullptr;
  }
  auto port = std::unique_ptr<UsbPort>(new UsbPort(std::move(impl)));
  UsbDeviceInfo& info = port->info_;
  info = info_of(libusb_get_device(port->impl_->handle));
  if (info.vendor != selector.vendor || info.product != selector.product) {
    why = selector.file.string() + " is a device " + hex(info.vendor, info.product) + ", not " + numbers;
    return nullptr;
  }
  read_texts(info, port->impl_->handle);
  port->identity_ = identity_of(info, selector.file);
  if (!selector.serial.empty() && info.serial != selector.serial) {
    why = "device " + numbers + " has serial number \"" + info.serial + "\", not \"" + selector.serial + "\"";
    return nullptr;
  }
  return port;
}

std::string libusb_version() {
  const struct ::libusb_version* v = libusb_get_version();
  return std::to_string(v->major) + "." + std::to_string(v->minor) + "." + std::to_string(v->micro);
}

}  // namespace tactor
