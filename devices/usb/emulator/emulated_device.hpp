// What all emulated haptic devices do alike: their arm moves, faults come over them, and what they did is written down.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>

#include "devices/usb/emulator/emulation.hpp"
#include "devices/usb/emulator/usb_function.hpp"

namespace tactor {

/// What a device knows while it has power. It lies in a file that all processes map which open the device one after
/// another, so that the device outlives them.
struct PoweredState {
  std::uint32_t plugs = 1;  ///< times it was plugged in
  std::uint32_t plugged = 1;
  std::uint32_t firmware = 0;   ///< a Falcon has its firmware
  std::uint32_t homed = 0;      ///< a Falcon's encoders have found their zero
  std::uint32_t lost_zero = 0;  ///< counts by which the encoders are off
};

/// Maps the state in that file, which is made where there is none; a state of this process alone where `file` is empty
/// or cannot be mapped.
std::shared_ptr<PoweredState> map_state(const std::string& file);

/// A device with an arm in a hand, which holds its first button, where it has one. The effort of its motors holds from
/// one command to the next, also when the host closes it, and is zero where none has come for the watchdog's time.
/// Between two hosts the hand puts the handle back to where it starts.
class EmulatedDevice : public UsbFunction {
 public:
  EmulatedDevice(const Emulation& emulation, std::shared_ptr<PoweredState> state);
  ~EmulatedDevice() override;

  void tick(double dt) override;
  void opened() override;
  void closed() override;
  std::optional<std::size_t> control(const UsbSetup& setup, std::span<std::uint8_t> data) override;

  /// From now on; `well` ends all. Unplugging is the caller's.
  void begin(UsbFault fault);
  void lose_power();
  [[nodiscard]] bool is_driven() const;
  [[nodiscard]] const EmulatedArm& arm() const { return arm_; }
  /// N or N m, in use now.
  [[nodiscard]] const std::array<double, 6>& effort() const { return effort_; }
  [[nodiscard]] double largest_effort() const { return largest_effort_; }

 protected:
  /// The command that came.
  void drive(const std::array<double, 6>& effort);
  /// What the encoders show as coordinates, faults included.
  [[nodiscard]] std::array<double, 6> shown() const;
  [[nodiscard]] bool has(UsbFault fault) const { return (faults_ & (1U << static_cast<unsigned>(fault))) != 0; }
  [[nodiscard]] const Emulation& emulation() const { return e_; }
  [[nodiscard]] PoweredState& state() { return *state_; }
  /// Spoils the bytes of a report where a fault says so; nothing where the device is silent.
  std::optional<std::vector<std::uint8_t>> spoilt(std::vector<std::uint8_t> report);

 private:
  void write_down();

  Emulation e_;
  std::shared_ptr<PoweredState> state_;
  EmulatedArm arm_;
  std::array<double, 6> effort_{};
  std::array<double, 6> stuck_at_{}, jump_{};
  double since_command_ = 0, largest_effort_ = 0, time_ = 0, written_ = 0;
  std::uint32_t faults_ = 0;
  std::FILE* trace_ = nullptr;
  std::minstd_rand random_{1};
};

/// A device whose reports and commands have the layouts of the emulation. Its counters begin at zero when it is plugged
/// in, wherever it is then; they are those of a device without a zero of its own where that is asked for.
///
/// One that answers does as the board of the Polhem: it makes a report of what it sees, waits until the host has taken
/// it, for as long as that may be, and only then looks for a command.
class ReportDevice final : public EmulatedDevice {
 public:
  using EmulatedDevice::EmulatedDevice;
  [[nodiscard]] std::vector<std::uint8_t> descriptors() override;
  void out(std::uint8_t endpoint, std::span<const std::uint8_t> data) override;
  std::optional<std::vector<std::uint8_t>> in(std::uint8_t endpoint) override;
  void opened() override;

 private:
  [[nodiscard]] std::vector<std::uint8_t> report();
  void obey(std::span<const std::uint8_t> command);

  std::optional<std::vector<std::uint8_t>> made_;     // a report that the host has not taken
  std::optional<std::vector<std::uint8_t>> command_;  // that waits until then
  std::uint32_t plugs_ = 0;                           // when `made_` was made
};

/// The device that the emulation says.
std::unique_ptr<EmulatedDevice> make_emulated_device(const Emulation& emulation, std::shared_ptr<PoweredState> state);

}  // namespace tactor
