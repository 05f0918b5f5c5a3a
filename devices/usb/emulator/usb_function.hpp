// What an emulated USB device does: its descriptors, and its answers to requests and transfers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tactor {

/// The eight bytes that begin a control transfer (USB 2.0, 9.3).
struct UsbSetup {
  std::uint8_t type = 0;  ///< bmRequestType; bit 7: data goes to the host
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

/// The far end of the cable. UsbfsNode calls it with its lock held, so that no two calls overlap.
class UsbFunction {
 public:
  virtual ~UsbFunction() = default;

  /// The device descriptor and after it the configuration descriptors, as usbfs gives them to who reads the node.
  [[nodiscard]] virtual std::vector<std::uint8_t> descriptors() = 0;
  /// A control transfer; `data` is what the host sends, or the room for the answer. The number of bytes that went, or
  /// nothing: the request is not known (a stall).
  virtual std::optional<std::size_t> control(const UsbSetup& setup, std::span<std::uint8_t> data) = 0;
  /// Bytes that the host sent to an OUT endpoint.
  virtual void out(std::uint8_t endpoint, std::span<const std::uint8_t> data) = 0;
  /// What an IN endpoint has to send now; nothing: not ready, ask again. It may be longer than the host has room for,
  /// which the host sees as an overflow.
  virtual std::optional<std::vector<std::uint8_t>> in(std::uint8_t endpoint) = 0;
  /// A frame of USB passes, `dt` seconds after the last one; only while the device is open.
  virtual void tick(double dt) { static_cast<void>(dt); }
  /// The host has opened or closed the device.
  virtual void opened() {}
  virtual void closed() {}
};

/// A standard request for a descriptor answered from `descriptors` and `texts`, the strings from index 1 on; nothing
/// where the request asks for something else.
std::optional<std::size_t> answer_standard_request(const UsbSetup& setup, std::span<std::uint8_t> data,
                                                   std::span<const std::uint8_t> descriptors,
                                                   std::span<const char* const> texts);

/// An endpoint as its descriptor tells it.
struct EndpointDescription {
  std::uint8_t address = 0;     ///< bit 7: to the host
  std::uint8_t attributes = 3;  ///< 2 bulk, 3 interrupt
  std::uint16_t packet = 64;    ///< largest packet, bytes
  std::uint8_t interval = 1;    ///< ms, of an interrupt endpoint at full speed
};

/// The descriptors of a full-speed device of one configuration and one interface, with strings 1 (maker), 2 (product)
/// and 3 (serial number).
std::vector<std::uint8_t> make_descriptors(std::uint16_t vendor, std::uint16_t product, std::uint8_t interface_class,
                                           std::span<const EndpointDescription> endpoints);

}  // namespace tactor
