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
  std::uint64_t cuts = 0;             ///< how often the command was cut to zero, see LinkRunner
  LinkError error = LinkError::none;  ///< of the newest cycle or attempt to connect
  std::array<char, 240> text{};       ///< why, in words, with the device's name
};

/// Opens a Link and exchanges one command and one sample a cycle, at absolute deadlines, on a thread of its own; cycles
/// that are due while one is under way are skipped. A device that sets the pace is waited for instead, and no more than
/// one and a half periods ahead of the deadlines. The device loop hands commands over and takes reports by
/// EdgeQueue: it never waits, allocates or locks.
///
/// The thread takes over the policy that the loop's thread has at its first command, one priority below it where that
/// is a real-time one: the loop goes before its line, and a graph that gives the loop less gives the line less too.
///
/// The command is *cut*, zero is sent whatever the loop commands, from every opening of the line on, and from a command
/// on that is older than command_age_max, until the loop has commanded exactly zero once after that. The loop sees a
/// cut by `cuts`, disengages, and engages anew by its ramp, so a force never comes back at once. A zero counts
/// however short it was: a slow line need not have had a cycle in it.
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

  // Metrics, readable by any thread while it runs.
  [[nodiscard]] std::int64_t cycles() const { return cycles_.value(); }  ///< good ones
  /// Of these, those that gave the device an effort other than zero.
  [[nodiscard]] std::int64_t forced_cycles() const { return forced_cycles_.value(); }
  [[nodiscard]] std::int64_t errors(LinkError error) const { return errors_[static_cast<std::size_t>(error)].value(); }
  [[nodiscard]] std::int64_t reconnects() const { return reconnects_.value(); }
  [[nodiscard]] std::int64_t skipped() const { return skipped_.value(); }  ///< cycles that were due in another
  [[nodiscard]] const LatencyHistogram& cycle_time() const { return *cycle_time_; }
  /// The newest failure in words, with the device's name; empty: none.
  [[nodiscard]] std::string last_failure() const;
  /// What the system did not grant to the thread, in words.
  [[nodiscard]] std::vector<std::string> refused() const;
  [[nodiscard]] const std::string& name() const { return name_; }  ///< of the link

 private:
  /// What goes to the thread.
  struct Order {
    LinkCommand command;
    Instant zeroed;  // when zero was commanded last
  };

  struct LoopPolicy {
    int policy = 0;  // as the system numbers them
    int priority = 0;
    int nice = 0;
  };

  void run();
  bool open();
  bool back_off();  // pauses; false: it is to stop
  void remember_policy() noexcept;
  void take_policy();
  void cycle(Instant began);
  LinkCommand due_command(Instant now);
  void cut();
  void failed(const LinkFailure& failure);
  void publish();
  void shut_down();
  bool pause(Duration length);  // false: it is to stop
  [[nodiscard]] bool stopping() const { return stop_.load(std::memory_order_acquire); }

  std::unique_ptr<Link> link_;
  const LinkRunnerSettings settings_;
  const std::string name_;
  EdgeQueue commands_{sizeof(Order), alignof(Order), Queue{}};
  EdgeQueue reports_{sizeof(LinkReport), alignof(LinkReport), Queue{}};
  // The loop's.
  std::uint64_t commands_sent_ = 0;
  Instant zeroed_{INT64_MIN};
  bool policy_told_ = false;
  LoopPolicy policy_;  // written by the loop before the flag
  std::atomic<bool> policy_known_{false};

  // The thread's.
  bool is_open_ = false;
  bool cut_ = true;
  Instant cut_since_;
  Order newest_;
  Instant commanded_;  // when
  bool any_command_ = false;
  int failures_in_a_row_ = 0;
  bool policy_taken_ = false;
  bool any_good_ = false;  // since it was opened
  Duration back_off_;
  std::uint64_t sessions_ = 0;
  std::uint64_t reports_sent_ = 0;
  LinkReport report_;

  LoopCounter cycles_, forced_cycles_, reconnects_, skipped_;
  std::array<LoopCounter, link_error_count> errors_;
  std::unique_ptr<LatencyHistogram> cycle_time_;

  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;  // of what follows; the loop never takes it
  std::condition_variable wake_;
  std::string last_failure_;
  std::vector<std::string> refused_;
  std::thread thread_;
};

}  // namespace tactor
