// The line to a device of hardware: what a concrete transport does, and how it fails.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "devices/hardware/line_data.hpp"

namespace tactor {

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
  std::string text;        ///< in words, without the device's name
  bool reopen = false;     ///< the connection is of no use any more
  bool asks_user = false;  ///< it will not open before the user has done what `text` says
};

/// Who says when a cycle of a line begins.
enum class LinkPace : std::uint8_t {
  deadlines,  ///< the runner, at absolute deadlines
  /// The device, which sends at its own pace: `exchange` waits for it. A cycle may then begin as soon as the one before
  /// has ended, up to one and a half periods before it is due: two clocks that both set the pace would beat.
  device,
  callback,  ///< a thread of the device's library, which calls LinkTurn::turn in place of `exchange`
};

/// What a thread of the device's library calls between `start` and `close` of a link whose pace is `callback`.
class LinkTurn {
 public:
  virtual ~LinkTurn() = default;
  /// One cycle: takes what the device shows now, and returns what it is to do from now on. `fault` has the words for
  /// `sample.faults`. Allocates and waits for nothing where there is no fault.
  virtual LinkCommand turn(const LinkSample& sample, std::string_view fault = {}) = 0;
  /// A cycle without a sample. With `failure.reopen` the link is closed and opened anew, on another thread.
  virtual void failed(const LinkFailure& failure) = 0;
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
  /// Constant.
  [[nodiscard]] virtual LinkPace pace() const { return LinkPace::deadlines; }
  /// Connects, makes sure that the right device answers before anything is written to it, and starts it up with zero
  /// effort. False, with why, where that fails; then nothing is open.
  virtual bool open(LinkFailure& failure) = 0;
  /// What the device has said of itself when it was opened; asked after each `open`.
  [[nodiscard]] virtual LinkLimits limits() const { return {}; }
  /// One cycle: gives the device `command` and reads `sample`. False, with why, where either failed; `sample` is then
  /// of no use. A device that reports a fault is no failure: `sample.faults` tells, and `failure` has it in words. Not
  /// called where the pace is `callback`.
  virtual bool exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure);
  /// Once after each `open`, where the pace is `callback`: from now on until `close` the library's thread calls `turn`.
  virtual void start(LinkTurn& turn);
  /// Ends the connection; before that, where it still works, commands zero and shuts the device down. Where nothing is
  /// open it does nothing. From its return on `turn` is not called.
  virtual void close() = 0;
};

}  // namespace tactor
