// The line to a Novint Falcon: its serial chip, its firmware, its homing, and a packet each way a cycle.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/falcon/packet.hpp"
#include "devices/hardware/link.hpp"
#include "devices/usb/usb_port.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// The bytes of a firmware file. Throws InputError where it cannot be read or cannot be a firmware by its size.
std::vector<std::uint8_t> read_falcon_firmware(const std::filesystem::path& file);

/// Opening sets the chip up, loads the firmware where the device has none, and waits for two seconds at most until a
/// person has homed it (all arms moved past their marks); it takes ten seconds at most. Axes are the arms' angles in
/// rad, efforts their torques in N m.
///
/// Motors get what is commanded only in the answer to a packet that says that all encoders are homed, never more than
/// word_max; in all other packets, and in the last one before closing, they get zero.
class FalconLink final : public Link, private UsbListener {
 public:
  /// `firmware` empty: the device must have its own already. Makes the connection to libusb, but opens no device.
  FalconLink(std::vector<std::uint8_t> firmware, const UsbChoice& choice);

  [[nodiscard]] std::string name() const override { return "falcon (USB 0403:cb48)"; }
  bool open(LinkFailure& failure) override;
  [[nodiscard]] LinkPace pace() const override { return LinkPace::device; }
  bool exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) override;
  void close() override;

 private:
  void received(std::span<const std::uint8_t> bytes) override;
  bool open_port(LinkFailure& failure);
  bool request(std::uint8_t request, std::uint16_t value, LinkFailure& failure);
  bool run_mode(LinkFailure& failure);
  bool load_firmware(LinkFailure& failure);
  bool answers(LinkFailure& failure);
  bool home(LinkFailure& failure);
  bool wait(Duration most, LinkFailure& failure);
  bool write(std::span<const std::uint8_t> bytes, LinkFailure& failure);
  bool expect(std::span<const std::uint8_t> bytes, Duration most, LinkFailure& failure);
  bool order(const FalconOrder& order, LinkFailure& failure);
  bool wait_for_state(Duration most, LinkFailure& failure);

  std::vector<std::uint8_t> firmware_;
  UsbSelector selector_;
  UsbBus bus_;
  std::unique_ptr<UsbPort> port_;
  bool running_ = false;  // packets are looked for in what comes; else it is kept as it is
  FalconStream stream_;
  std::vector<std::uint8_t> bytes_;
  FalconState state_;
  bool fresh_ = false;
  std::uint64_t spoilt_ = 0;  // packets that were none
};

}  // namespace tactor
