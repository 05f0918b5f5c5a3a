// The faults of an emulated line as they wait, begin and end, and what they do to the device and to its answers.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "devices/modbus/emulator/device.hpp"
#include "devices/modbus/emulator/faults.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor::modbus {

/// Begins each fault when its time comes, and ends one that lasts after its duration.
class FaultSchedule {
 public:
  /// `serial`: the line is a serial one, else TCP.
  FaultSchedule(const std::vector<Fault>& faults, bool serial);

  void add(const Fault& fault) { faults_.push_back({fault}); }
  /// A request has come.
  void asked() {
    if (!first_request_) first_request_ = MonotonicClock::now();
  }
  void begin_due(EmulatedDevice& device);
  void end_due(EmulatedDevice& device);
  /// Ends all that have begun.
  void end_all(EmulatedDevice& device);

  /// The first fault of this kind that has begun and is not over; null: none.
  [[nodiscard]] const Fault* active(FaultKind kind) const;
  /// The same, and it is over.
  const Fault* take(FaultKind kind);
  /// Changes an answer as the faults want it; returns how often.
  unsigned disturb(std::vector<std::uint8_t>& frame);
  /// Whether a fault ends the connections; once.
  bool take_drop() { return std::exchange(drop_clients_, false); }

 private:
  struct Entry {
    Fault fault;
    bool begun = false;
    bool over = false;
    Instant began;
  };

  void begin(Entry& entry, EmulatedDevice& device);
  void put_check_sum(std::vector<std::uint8_t>& frame) const;

  const bool serial_;
  std::vector<Entry> faults_;
  std::optional<Instant> first_request_;
  bool drop_clients_ = false;
};

}  // namespace tactor::modbus
