// The line of a device as its loop sees it, wherever the line's thread is.
#pragma once

#include <string>
#include <vector>

#include "devices/hardware/line_cycle.hpp"

namespace tactor {

/// A line that is kept open and driven by somebody else: a thread of this process (LinkRunner), or one of a process
/// that outlives this one (GuardedLine).
class DeviceLine {
 public:
  DeviceLine() = default;
  /// As `stop`.
  virtual ~DeviceLine() = default;
  DeviceLine(const DeviceLine&) = delete;
  DeviceLine& operator=(const DeviceLine&) = delete;

  /// Begins to open the line. Throws InputError where what it needs is not there, RunError where the system refuses.
  virtual void start() = 0;
  /// Commands zero, shuts the device down and closes the line. Takes as long as the link's calls.
  virtual void stop() = 0;

  /// Device loop: the newest report; false, and nothing copied, where there is none since the last call. Wait-free.
  virtual bool newest(LinkReport& report) noexcept = 0;
  /// Device loop: the command from now on. Wait-free.
  virtual void command(Instant now, const LinkCommand& command) noexcept = 0;
  /// What the loop may wait for: the samples of a line that sets the pace. Null: the line follows a clock.
  [[nodiscard]] virtual Pace* pace() = 0;

  // Readable by any thread while it runs.
  [[nodiscard]] virtual const LinkMetrics& metrics() const = 0;
  /// The newest failure in words, with the device's name; empty: none.
  [[nodiscard]] virtual std::string last_failure() const = 0;
  /// What the system did not grant to the thread of the line, in words.
  [[nodiscard]] virtual std::vector<std::string> refused() const = 0;
  [[nodiscard]] virtual const std::string& name() const = 0;  ///< of the link
};

}  // namespace tactor
