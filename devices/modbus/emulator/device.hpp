// The actuator behind an emulated Modbus line: its registers, its motion, its watchdog.
#pragma once

#include <cstdint>
#include <vector>

#include "devices/modbus/profile.hpp"
#include "framework/core/time.hpp"

namespace tactor::modbus {

/// What went on inside at one instant.
struct EmulatedState {
  double position = 0;         ///< m, of the first axis, as it truly is
  double force = 0;            ///< N, that acts on it now
  double commanded = 0;        ///< N, as the registers have it
  bool expired = false;        ///< its watchdog has run out
  std::uint64_t commands = 0;  ///< writes of an effort so far
  double given = 0;            ///< J, net, that the efforts of all axes have given so far, by the steps of `advance`
  Time time;                   ///< of all that, by the device's clock, which is that of `advance`
};

/// The registers of a profile and a mass behind each axis: M a = F - b v - k (x - hand), between two hard ends, where F
/// is the effort of its registers and the hand is at rest + swing sin(2 pi swing_rate t), a quarter further an axis.
///
/// The effort acts while the `enabled` register says so and the watchdog has not run out. The watchdog runs out where
/// no effort has been written for the time in its register; it then sets its bit in the `error` register, and the
/// effort stays away until that register is zero again and a command has come (without such a register, until a command
/// has come).
class EmulatedDevice {
 public:
  explicit EmulatedDevice(Profile profile);

  /// A request has come, whatever it asks for.
  void asked() {
    since_request_s_ = 0;
    any_request_ = true;
  }
  /// Moves on to `now`, which does not run backwards, in steps of at most half a millisecond.
  void advance(Time now);
  /// Reads words; false where the device has not all of them: it has those of its profile's registers and fence, and
  /// what lies between two registers within the profile's read_gap.
  bool read(int address, int count, std::uint16_t* words);
  /// Writes words; false where one belongs to no register.
  bool write(int address, int count, const std::uint16_t* words);

  void jump(double by) { shown_offset_ += by; }  ///< m: the encoder shows this much more from now on
  void stick(bool stuck) { stuck_ = stuck; }     ///< the encoder shows what it showed last
  void set_error(int bit);                       ///< in the error register, else in the first status register
  void become_another();                         ///< what identifies it reads as other values
  [[nodiscard]] EmulatedState state() const;
  [[nodiscard]] const Profile& profile() const { return profile_; }
  /// Seconds for which the command has been other than zero without a break.
  [[nodiscard]] double driven_for() const { return driven_s_; }

 private:
  void know_addresses();
  void step(double dt);
  void show();
  [[nodiscard]] double effort_of(const Axis& axis) const;
  [[nodiscard]] bool enabled() const;
  [[nodiscard]] double get(std::size_t index) const;
  void put(std::size_t index, double value);

  Profile profile_;
  std::vector<std::uint16_t> words_;
  std::vector<bool> declared_, readable_;  // by address
  std::vector<double> x_, v_, force_, shown_;
  double given_ = 0;  // J
  Time now_;
  bool begun_ = false;
  double since_command_s_ = 0;
  bool any_command_ = false;
  std::uint64_t commands_ = 0;
  double since_request_s_ = 0;
  bool any_request_ = false;
  bool expired_ = false;
  double driven_s_ = 0;
  double shown_offset_ = 0;
  bool stuck_ = false;
};

}  // namespace tactor::modbus
