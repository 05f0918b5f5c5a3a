// USB devices by libusb: the bus, which finds and opens them, and a port, which keeps transfers going on one of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "devices/hardware/link.hpp"
#include "framework/core/time.hpp"

struct libusb_context;

namespace tactor {

/// How a transfer or a request ended.
enum class UsbResult : std::uint8_t {
  ok,
  timeout,       ///< no answer in time
  disconnected,  ///< the device has gone
  stalled,       ///< the device does not know the request
  overflow,      ///< the device sent more than there was room for
  failed,        ///< anything else
};

/// What a kind of device is known by.
struct UsbNumbers {
  std::uint16_t vendor = 0, product = 0;
};

/// What a device tells of itself when it is found.
struct UsbDeviceInfo {
  std::uint16_t vendor = 0, product = 0;
  int bus = 0, address = 0;
  std::string path;  ///< `1-2.3`: the bus and the ports that lead to it; empty for a device opened by its file
  std::string maker, name, serial;  ///< its strings; empty where it has none or may not be opened
  bool may_open = false;
};

/// What became of a line by a transfer that was not ok. A device that has gone must be opened anew.
LinkFailure failure_of(UsbResult result);

/// Which device is meant.
struct UsbSelector {
  std::uint16_t vendor = 0, product = 0;
  std::string serial;          ///< empty: any
  std::filesystem::path file;  ///< of the device (/dev/bus/usb/...), instead of a search; empty: search
};

/// Which of the devices of a kind.
struct UsbChoice {
  std::string serial;          ///< empty: any
  std::filesystem::path file;  ///< /dev/bus/usb/..., instead of a search; empty: that of TACTOR_USB_FILE, or a search
};

/// The file that TACTOR_USB_FILE names where `choice` has none.
UsbSelector selector_of(std::uint16_t vendor, std::uint16_t product, const UsbChoice& choice);

/// The transfers of a port.
struct UsbTransfers {
  enum class Kind : std::uint8_t { interrupt, bulk };
  Kind kind = Kind::interrupt;
  int interface = 0;
  /// Endpoint addresses; 0: the first of the interface that has the kind and the direction.
  std::uint8_t in = 0, out = 0;
  std::size_t in_size = 64;   ///< bytes asked for; a multiple of the endpoint's packet
  std::size_t out_size = 64;  ///< the most that `send` takes
};

/// Who is told what comes. Called by UsbPort::wait, on its thread.
class UsbListener {
 public:
  virtual ~UsbListener() = default;
  /// An IN transfer has ended with so many bytes; it may be short or empty.
  virtual void received(std::span<const std::uint8_t> bytes) = 0;
};

/// One opened device. All of it belongs to one thread, apart from the device's loop: libusb allocates.
class UsbPort {
 public:
  /// Cancels what is on its way, waits for it, gives the interface back and closes.
  ~UsbPort();
  UsbPort(const UsbPort&) = delete;
  UsbPort& operator=(const UsbPort&) = delete;

  [[nodiscard]] const UsbDeviceInfo& info() const { return info_; }
  /// Names this device as long as it keeps its power: another text after each unplugging, each
  /// boot and each sleep of the machine, in which ports may lose their power.
  [[nodiscard]] const std::string& identity() const { return identity_; }

  /// A control transfer to or from the device (`type` bit 7).
  UsbResult control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                    std::span<std::uint8_t> data, Duration most);
  /// Claims the interface and begins to read. `listener` outlives the port. A failure, or empty; what the descriptors
  /// lack, such as an endpoint, says that the device is not the one it seems to be.
  std::string start(const UsbTransfers& transfers, UsbListener& listener);
  /// Sends bytes; False, and nothing sent, while the last ones are still on their way.
  bool send(std::span<const std::uint8_t> bytes);
  [[nodiscard]] bool sending() const;
  /// Lets transfers end for at most so long; returns as soon as one has. `ok` also where none did: what ended, and how,
  /// is told by the listener and by this result. An endpoint that has stalled is set free again, which the device
  /// answers within five seconds, or the kernel gives up.
  UsbResult wait(Duration most);

 private:
  friend class UsbBus;
  struct Impl;
  explicit UsbPort(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
  UsbDeviceInfo info_;
  std::string identity_;
};

/// libusb itself. Make it before a thread raises its priority: libusb starts a thread that inherits it.
class UsbBus {
 public:
  /// Throws RunError where libusb cannot be used.
  UsbBus();
  ~UsbBus();
  UsbBus(const UsbBus&) = delete;
  UsbBus& operator=(const UsbBus&) = delete;

  /// The devices of these kinds. No other one is opened: what they are is read by their descriptors alone.
  [[nodiscard]] std::vector<UsbDeviceInfo> devices(std::span<const UsbNumbers> kinds) const;
  /// Opens the first device that fits; null, with the reason and the remedy in `why`, where there is none or it may not
  /// be opened.
  std::unique_ptr<UsbPort> open(const UsbSelector& selector, std::string& why);

 private:
  libusb_context* context_ = nullptr;
};

/// The version of libusb in use, `1.0.26`.
std::string libusb_version();

}  // namespace tactor
