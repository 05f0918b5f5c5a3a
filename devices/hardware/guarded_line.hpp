// A line whose thread runs in tactor-guard, a process of its own: it takes the force to zero where this one dies.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/hardware/device_line.hpp"
#include "devices/hardware/guard_share.hpp"
#include "devices/hardware/link.hpp"
#include "framework/core/file_descriptor.hpp"

namespace tactor {

/// Where the line of a device runs.
enum class GuardChoice : std::uint8_t {
  automatic,  ///< in the guard, where the device has no watchdog of its own below 100 ms
  on,
  off,
};

/// A line that a guard can open: the kind of it, and the bytes of what its link is made of (see
/// devices/guard/lines.cpp).
struct GuardableLink {
  std::string line;
  std::string link;
};

/// Starts tactor-guard and hands commands and reports over by shared memory, without a lock or a system call.
///
/// The guard has a session of its own, so that neither a signal from the terminal nor the end of this process ends it.
/// It ends by itself: where this process has gone or has asked it to, and once the force is zero and the device shut
/// down.
class GuardedLine final : public DeviceLine {
 public:
  /// `link` tells its name and its pace; it is never opened here. The guard tells `flight` each cycle, if its ring has
  /// a file. Throws RunError where there is no shared memory.
  GuardedLine(std::unique_ptr<Link> link, GuardConfig config, const FlightWriter& flight = {});
  ~GuardedLine() override;

  /// Throws InputError where the program tactor-guard is not there, RunError where it does not start.
  void start() override;
  void stop() override;

  bool newest(LinkReport& report) noexcept override;
  void command(Instant now, const LinkCommand& command) noexcept override;
  [[nodiscard]] Pace* pace() override { return link_->pace() == LinkPace::device ? &share_->board.pace : nullptr; }

  [[nodiscard]] const LinkMetrics& metrics() const override { return share_->board.metrics; }
  /// Of the newest report that was read.
  [[nodiscard]] std::string last_failure() const override { return text_.data(); }
  [[nodiscard]] std::vector<std::string> refused() const override;
  [[nodiscard]] const std::string& name() const override { return name_; }
  /// The guard's process; 0: none runs.
  [[nodiscard]] pid_t process() const { return process_; }

 private:
  struct Unmap {
    void operator()(GuardShare* share) const;
  };

  const std::unique_ptr<Link> link_;
  const GuardConfig config_;
  const std::string name_;
  const int flight_file_;  // of the ring; -1: there is none
  FileDescriptor file_;    // of the shared memory
  std::unique_ptr<GuardShare, Unmap> share_;
  SlotWriter<GuardOrder> orders_;
  SlotReader<LinkReport> reports_;
  pid_t process_ = 0;

  // The loop's.
  Instant zeroed_{INT64_MIN};
  std::uint64_t epoch_ = 0;
  std::array<char, sizeof(LinkReport::text)> text_{};
};

}  // namespace tactor
