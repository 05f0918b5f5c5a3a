// What Tactor knows of a Modbus device: its line, its registers, how it is started, driven, watched and shut down.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "devices/modbus/register_map.hpp"
#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor::modbus {

/// The line as the device expects it.
struct LineSettings {
  int baud = 19200;
  char parity = 'E';  ///< N, E or O
  int stop_bits = 1;
  int unit = 1;                           ///< slave id, 1 to 247
  Duration response_timeout{50'000'000};  ///< from the request to the last byte of the answer
  Duration turnaround{1'000'000};         ///< that the device takes to answer
  std::optional<Duration> silence;        ///< between frames; absent: 3.5 characters, above 19200 baud 1.75 ms
  double rate_max = 1000;                 ///< Hz, of what the device takes

  /// Bits of a character on the line, start bit included.
  [[nodiscard]] int character_bits() const { return 1 + 8 + (parity == 'N' ? 0 : 1) + stop_bits; }
  [[nodiscard]] Duration character() const {
    return Duration::from_seconds(character_bits() / static_cast<double>(baud));
  }
  [[nodiscard]] Duration silent() const;
};

/// A register must read as a value within these bounds (SI).
struct Expectation {
  std::size_t index = 0;  ///< into Profile::registers
  double min = 0, max = 0;
};

/// A step of a sequence.
struct Step {
  enum class Kind : std::uint8_t { write, wait, expect };
  Kind kind = Kind::wait;
  std::size_t index = 0;  ///< of the register
  double value = 0;       ///< SI: written, or expected to be read
  Duration time;          ///< waited, or the longest that `expect` asks again
};

/// One axis: where it is, and how it is pushed.
struct Axis {
  std::size_t position = 0;                     ///< register
  std::size_t effort = 0;                       ///< register
  Vec3 direction{0, 0, 1};                      ///< in the device's base, in which its position grows
  double effort_max = 0;                        ///< N
  double effort_continuous = 0;                 ///< N that the motor bears for ever; 0: not known
  double thermal_time = 0;                      ///< s, of its winding; 0: not known
  double speed_max = 1;                         ///< m/s
  double jump_tolerance = 0;                    ///< m
  bool magnitude = false;                       ///< the register takes the size of the effort alone
  std::optional<std::size_t> sign;              ///< the register that takes its direction instead
  double positive = 0, negative = 0, zero = 0;  ///< values (SI) of that register
};

struct StatusBit {
  int bit = 0;
  std::string means;
  bool fault = true;
};
/// A register whose bits say how the device is, or which keeps a value as long as nobody else writes to the device.
struct Status {
  std::size_t index = 0;
  std::vector<StatusBit> bits;
  bool others_are_faults = false;  ///< a bit that is not listed is a fault too
  std::optional<double> holds;     ///< SI; another value is a fault: another master has written to the device
  int every = 1;                   ///< read in each n-th cycle
};

/// A bit that is a button.
struct Button {
  std::size_t index = 0;
  int bit = 0;
};

/// The device's own watchdog: without a command for `time` it takes its force to zero.
struct Watchdog {
  std::size_t index = 0;  ///< the register of its time
  Duration time;
};

/// A read that no answer to another one can be taken for: see Client.
struct Fence {
  int function = 3;
  int address = 0;
  int count = 0;
};

/// How the emulated device moves: a mass on a damper and a spring towards where a hand holds it.
struct EmulatedDynamics {
  double mass = 0.5;                                    ///< kg
  double damping = 10;                                  ///< N s/m
  double stiffness = 200;                               ///< N/m
  double travel = 0.15;                                 ///< m, from 0
  double rest = 0.05;                                   ///< m, where the hand holds it
  double swing = 0;                                     ///< m, of the hand's motion
  double swing_rate = 0.5;                              ///< Hz
  std::optional<Expectation> enabled;                   ///< the effort acts while this register holds that
  std::optional<std::size_t> error;                     ///< the register of its faults
  std::vector<std::pair<std::size_t, double>> initial;  ///< registers (SI) when it is switched on; others are 0
  /// When `when` is written as `value`, `sets` becomes `to` (SI).
  struct Reaction {
    std::size_t when = 0;
    double value = 0;
    std::size_t sets = 0;
    double to = 0;
  };
  std::vector<Reaction> reacts;
  int watchdog_bit = 0;  ///< set there when the watchdog has run out
  /// When no request has come for `after`, `sets` becomes `to` (SI); the effort goes on.
  struct Silence {
    Duration after;
    std::size_t sets = 0;
    double to = 0;
  };
  std::optional<Silence> silence;
};

/// Where a profile says what can be wrong with it as a whole, for error texts.
struct ProfilePlaces {
  SourceLocation file, cycle, fence, watchdog;  ///< those of keys are that of the file where it lacks them
};

struct Profile {
  std::string name;  ///< of the file, without its ending
  std::string title;
  ProfilePlaces places;
  LineSettings line;
  std::vector<RegisterInfo> registers;
  std::vector<Expectation> identify;  ///< at least one
  std::vector<Step> start_up, shut_down, calibrate;
  std::vector<std::pair<std::size_t, double>> each_cycle;  ///< registers that are written anew with each command (SI)
  std::vector<std::pair<std::size_t, double>> at_zero;     ///< in place of those where all efforts are zero (SI)
  bool combined = false;                                   ///< a cycle writes and reads with function 23
  int read_gap = 0;  ///< words that no register names and that may be read between two that are asked for at once
  std::vector<Status> status;
  std::vector<Button> buttons;
  std::optional<Watchdog> watchdog;
  std::optional<Fence> fence;
  std::vector<Axis> axes;
  EmulatedDynamics emulated;

  /// The registers that a command writes, each once.
  [[nodiscard]] std::vector<std::size_t> written_each_cycle() const;
};

/// Reads a profile. Throws YamlError with every error there is, each with file:line:column.
Profile read_profile(const std::filesystem::path& file);
/// The same of a text; `file` is what errors call it.
Profile parse_profile(const std::string& text, const std::string& file);

}  // namespace tactor::modbus
