// The line to a device of hardware: what a concrete transport does on a thread of its own, and what passes over it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace tactor {

/// The most axes a device may have.
inline constexpr int max_axes = 6;
/// A value for each axis of a device, in the order of the device; those beyond its number of axes are zero.
using AxisValues = std::array<double, max_axes>;

/// What a device is to do: an effort an axis, N where the axis slides and N m where it turns, on the device, in the
/// direction in which its coordinate grows.
struct LinkCommand {
  AxisValues effort{};
  [[nodiscard]] bool is_zero() const { return effort == AxisValues{}; }
};

/// What a device shows of itself.
struct LinkSample {
  AxisValues q{};             ///< m where the axis slides, rad where it turns
  std::uint32_t buttons = 0;  ///< one bit a button that is held
  std::uint32_t faults = 0;   ///< bits of a fault that the device itself reports, as the link numbers them; 0: none
};

/// How a line fails.
enum class LinkError : std::uint8_t {
  none,
  timeout,       ///< no answer, or not all of it, in time
  crc,           ///< an answer whose check sum is wrong
  exception,     ///< the device answered that it would not
  protocol,      ///< a mismatched response (length, slave, function, transaction)
  reset,         ///< the connection was ended by the other side, or the device pulled out
  disconnected,  ///< no connection could be made
  identity,      ///< what answers is not the device that was expected
  device_fault,  ///< the line is well and the device reports a fault of its own
};
inline constexpr int link_error_count = 9;
/// The name of an error, as metrics and texts spell it.
std::string_view name_of(LinkError error);

/// Why something on the line failed.
struct LinkFailure {
  LinkError error = LinkError::none;
  std::string text;     ///< in words, without the device's name
  bool reopen = false;  ///< the connection is of no use any more
};

/// The line to one device. All of it is called by one thread, which may block in it, allocate and throw nothing; every
/// call returns in a bounded time that the link states in its documentation.
class Link {
 public:
  Link() = default;
  virtual ~Link() = default;
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// What is at which address, for error texts: `iris_orca at 127.0.0.1:1502, unit 1`. Constant.
  [[nodiscard]] virtual std::string name() const = 0;
  /// Connects, makes sure that the right device answers before anything is written to it, and starts it up with zero
  /// effort. False, with why, where that fails; then nothing is open.
  virtual bool open(LinkFailure& failure) = 0;
  /// Whether `exchange` waits for what the device sends at its own pace. A cycle may then begin as soon as the one
  /// before has ended, up to one and a half periods before it is due: two clocks that both set the pace would beat.
  [[nodiscard]] virtual bool sets_pace() const { return false; }
  /// One cycle: gives the device `command` and reads `sample`. False, with why, where either failed; `sample` is then
  /// of no use. A device that reports a fault is no failure: `sample.faults` tells, and `failure` has it in words.
  virtual bool exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) = 0;
  /// Ends the connection; before that, where it still works, commands zero and shuts the device down. Where nothing is
  /// open it does nothing.
  virtual void close() = 0;
};

}  // namespace tactor
