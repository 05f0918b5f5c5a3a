// The thread that talks to a device, and the wait-free ways between it and the device loop.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "devices/hardware/command_channel.hpp"
#include "devices/hardware/inherited_policy.hpp"
#include "devices/hardware/link.hpp"
#include "framework/core/time.hpp"
#include "framework/node/edge_queue.hpp"
#include "framework/realtime/loop_statistics.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// The choices of a LinkRunner.
struct LinkRunnerSettings {
  double rate = 1000;                    ///< Hz, of the cycles
  Duration command_age_max{50'000'000};  ///< an older command counts as zero: the loop has stopped
  Duration idle_after{1'000'000'000};    ///< without a command for so long the device is shut down
  Duration back_off{100'000'000};        ///< before the next attempt to connect; doubles until a cycle was good
  Duration back_off_max{2'000'000'000};  ///< the longest
  int failures_before_reopen = 5;        ///< failed cycles in a row
  std::string thread_name = "link";      ///< of the thread; cut to 15 characters
};

/// What the loop learns of the line.
struct LinkReport {
  LinkSample sample;                  ///< the newest good one
  Instant sampled;                    ///< when its cycle began, so that its age is not made smaller than it is
  std::uint64_t samples = 0;          ///< good ones so far; 0: `sample` is not set
  std::uint64_t cuts = 0;             ///< how often the command was cut to zero, see CommandChannel
  LinkError error = LinkError::none;  ///< of the newest cycle or attempt to connect
  std::array<char, 240> text{};       ///< why, in words, with the device's name
};

/// Metrics of a line. Its thread writes them, any thread may read them meanwhile.
struct LinkMetrics {
  LoopCounter cycles;         ///< good ones
  LoopCounter forced_cycles;  ///< of these, those that gave the device an effort other than zero
  LoopCounter reconnects;
  LoopCounter skipped;  ///< cycles that were due in another
  LatencyHistogram cycle_time;
  std::array<LoopCounter, link_error_count> by_error;

  [[nodiscard]] std::int64_t errors(LinkError error) const { return by_error[static_cast<std::size_t>(error)].value(); }
};

/// Opens a Link and exchanges one command and one sample a cycle, at absolute deadlines, on a thread of its own; cycles
/// that are due while one is under way are skipped. A device that sets the pace is waited for instead, and no more than
/// one and a half periods ahead of the deadlines. The device loop hands commands over and takes reports by
/// EdgeQueue: it never waits, allocates or locks.
///
/// The thread takes over the policy that the loop's thread has at its first command, one priority below it where that
/// is a real-time one: the loop goes before its line, and a graph that gives the loop less gives the line less too.
///
/// The command is cut from every opening of the line on, and where it grows older than command_age_max (see
/// CommandChannel). The loop sees a cut by `cuts`, disengages, and engages anew by its ramp, so a force never comes
/// back at once.
///
/// A line that fails failures_before_reopen times in a row, or says that it is of no use, is closed and opened again,
/// with a pause that doubles from attempt to attempt, also where it opens and then has no good cycle. Without any
/// command for idle_after the device is shut down and the line closed; a new command opens it.
class LinkRunner {
 public:
  LinkRunner(std::unique_ptr<Link> link, LinkRunnerSettings settings);
  /// As `stop`.
  ~LinkRunner();
  LinkRunner(const LinkRunner&) = delete;
  LinkRunner& operator=(const LinkRunner&) = delete;

  /// Makes the thread; the line is opened there.
  void start();
  /// Commands zero, shuts the device down, closes the line and joins the thread. Takes as long as the link's calls.
  void stop();

  /// Device loop: the newest report; false, and nothing copied, where there is none since the last call. Wait-free.
  bool newest(LinkReport& report) noexcept;
  /// Device loop: the command from now on. Wait-free.
  void command(Instant now, const LinkCommand& command) noexcept;

  // Readable by any thread while it runs.
  [[nodiscard]] const LinkMetrics& metrics() const { return metrics_; }
  /// The newest failure in words, with the device's name; empty: none.
  [[nodiscard]] std::string last_failure() const;
  /// What the system did not grant to the thread, in words.
  [[nodiscard]] std::vector<std::string> refused() const;
  [[nodiscard]] const std::string& name() const { return name_; }  ///< of the link

 private:
  void run();
  bool open();
  bool back_off();  // pauses; false: it is to stop
  void take_policy();
  void cycle(Instant began);
  LinkCommand due_command(Instant now);
  void failed(const LinkFailure& failure);
  void publish();
  void shut_down();
  bool pause(Duration length);  // false: it is to stop
  [[nodiscard]] bool stopping() const { return stop_.load(std::memory_order_acquire); }

  std::unique_ptr<Link> link_;
  const LinkRunnerSettings settings_;
  const std::string name_;
  CommandChannel commands_;
  EdgeQueue reports_{sizeof(LinkReport), alignof(LinkReport), Queue{}};
  InheritedPolicy policy_;

  // The thread's.
  bool is_open_ = false;
  int failures_in_a_row_ = 0;
  bool any_good_ = false;  // since it was opened
  Duration back_off_;
  std::uint64_t sessions_ = 0;
  LinkReport report_;

  LinkMetrics metrics_;

  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;  // of what follows; the loop never takes it
  std::condition_variable wake_;
  std::string last_failure_;
  std::vector<std::string> refused_;
  std::thread thread_;
};

}  // namespace tactor
