// The usbip protocol, by which the kernel's vhci-hcd speaks with a USB device that is somewhere else.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "devices/usb/emulator/usb_function.hpp"

namespace tactor {

// Layouts from the kernel's Documentation/usb/usbip_protocol: headers of 48 bytes, big end first, followed by the data.
namespace usbip {

constexpr std::size_t header_size = 48;
constexpr std::uint32_t cmd_submit = 1, cmd_unlink = 2, ret_submit = 3, ret_unlink = 4;
constexpr std::uint32_t data_max = 1U << 20U;  ///< bytes of one transfer; more is not believed

/// USBIP_CMD_SUBMIT or USBIP_CMD_UNLINK.
struct Request {
  bool unlink = false;
  std::uint32_t seqnum = 0;
  std::uint8_t endpoint = 0;   ///< its number; bit 7: data goes to the host
  std::uint32_t length = 0;    ///< bytes that follow to the device, or room for those from it
  UsbSetup setup;              ///< of a transfer of endpoint 0
  std::uint32_t unlinked = 0;  ///< the seqnum of the transfer that is called back

  [[nodiscard]] bool in() const { return (endpoint & 0x80U) != 0; }
  [[nodiscard]] std::size_t data_size() const { return unlink || in() ? 0 : length; }
};

/// Reads a header. Empty, or what is wrong with it: what comes after it cannot be understood then.
std::string read_request(std::span<const std::uint8_t, header_size> header, Request& request);

/// USBIP_RET_SUBMIT with a negative errno or zero; `data` is sent after it where it was an IN transfer, and `actual`
/// bytes are said to have gone.
std::vector<std::uint8_t> submit_answer(std::uint32_t seqnum, std::int32_t status, std::uint32_t actual,
                                        std::span<const std::uint8_t> data = {});
/// USBIP_RET_UNLINK: -ECONNRESET where the transfer was called back, 0 where it had ended before.
std::vector<std::uint8_t> unlink_answer(std::uint32_t seqnum, std::int32_t status);

/// The first free port of full and high speed in vhci-hcd's file `status`; -1 where there is none.
int free_port(const std::string& status);

}  // namespace usbip

/// Serves a device over usbip, as bytes that come and go. The device counts as open from the first transfer of an
/// endpoint other than 0 until none has been on its way for half a second, because usbip does not tell who opens it.
class UsbipServer {
 public:
  /// `function` outlives the server.
  explicit UsbipServer(UsbFunction& function);
  ~UsbipServer();
  UsbipServer(const UsbipServer&) = delete;
  UsbipServer& operator=(const UsbipServer&) = delete;

  /// Bytes from the host, in pieces of any size; control transfers are answered at once. Empty, or what is wrong with
  /// them: the connection is to be closed then, and the server takes nothing more.
  std::string receive(std::span<const std::uint8_t> bytes);
  /// A frame of USB, `dt` in s after the last one: one transfer of each interrupt endpoint, all that go of bulk ones.
  void frame(double dt = 1e-3);
  /// The bytes for the host since the last call.
  std::vector<std::uint8_t> take();
  [[nodiscard]] bool is_open() const { return open_; }

 private:
  struct Transfer {
    usbip::Request request;
    std::vector<std::uint8_t> data;
    bool interrupt = false;
  };

  std::string handle(const usbip::Request& request, std::span<const std::uint8_t> data);
  void unlink(const usbip::Request& request);
  void control(const usbip::Request& request, std::span<const std::uint8_t> data);
  std::string keep(const usbip::Request& request, std::span<const std::uint8_t> data);
  bool serve(const Transfer& transfer);
  void send(const std::vector<std::uint8_t>& bytes);

  UsbFunction& function_;
  std::array<std::uint8_t, 256> kinds_{};  // of endpoints by address: 2 bulk, 3 interrupt, 0 none
  std::vector<std::uint8_t> received_, outgoing_;
  std::deque<Transfer> pending_;
  bool open_ = false, broken_ = false;
  double idle_ = 0;
};

}  // namespace tactor
