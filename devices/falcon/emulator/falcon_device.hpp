// An emulated Falcon: its serial chip, its loader, its firmware and its arm.
#pragma once

#include <deque>

#include "devices/falcon/packet.hpp"
#include "devices/usb/emulator/emulated_device.hpp"

namespace tactor {

/// Until firmware has been loaded it answers the loader's questions alone; then a packet for each packet. Its encoders
/// find their zero, one after another, while homing is asked for and the hand moves the handle.
class FalconDevice final : public EmulatedDevice {
 public:
  using EmulatedDevice::EmulatedDevice;
  [[nodiscard]] std::vector<std::uint8_t> descriptors() override;
  std::optional<std::size_t> control(const UsbSetup& setup, std::span<std::uint8_t> data) override;
  void out(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  std::optional<std::vector<std::uint8_t>> in(std::uint8_t endpoint) override;
  void opened() override;
  void tick(double dt) override;

 private:
  void run(std::uint8_t byte);
  void answer_state();

  std::uint16_t baud_ = 0;
  bool loading_ = false;
  std::size_t loaded_ = 0;
  bool homing_ = false;
  std::array<double, 6> where_opened_{};
  std::deque<std::uint8_t> asked_;    // of the loader
  std::deque<std::uint8_t> waiting_;  // for the host
  FalconStream stream_;
};

}  // namespace tactor
