// An emulated device on a thread of its own: a frame of USB each millisecond, and faults when they are due.
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "devices/usb/emulator/emulated_device.hpp"
#include "devices/usb/emulator/usbfs_node.hpp"

namespace tactor {

class UsbEmulator {
 public:
  explicit UsbEmulator(const Emulation& emulation);
  /// Ends the thread.
  ~UsbEmulator();
  UsbEmulator(const UsbEmulator&) = delete;
  UsbEmulator& operator=(const UsbEmulator&) = delete;

  /// Begins the frames, on a thread at SCHED_FIFO 40 where the system allows it, so that a device keeps its time beside
  /// busy programs; else under the ordinary policy. The policy of the caller does not matter.
  void run();
  /// Ends them.
  void halt_frames();
  /// One frame, where nobody runs them; `dt` in s.
  void frame(double dt = 1e-3);
  /// A fault now.
  void begin(UsbFault fault);

  [[nodiscard]] UsbfsNode& node() { return node_; }
  /// To be looked at under node().locked, or while nobody else uses it.
  [[nodiscard]] EmulatedDevice& device() { return *device_; }
  [[nodiscard]] const std::atomic<bool>& driven() const { return driven_; }

 private:
  void loop();
  void take_orders();

  std::shared_ptr<PoweredState> state_;
  std::unique_ptr<EmulatedDevice> device_;
  UsbfsNode node_;
  FaultScript script_;
  int control_ = -1;
  std::string orders_;
  std::atomic<bool> driven_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tactor
