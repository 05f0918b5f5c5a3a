// The thread that opens the line to a device, keeps it open, and drives its cycles.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "devices/hardware/device_line.hpp"
#include "devices/hardware/inherited_policy.hpp"
#include "devices/hardware/line_cycle.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// The choices of a LinkRunner.
struct LinkRunnerSettings {
  double rate = 1000;                    ///< Hz, of the cycles
  CommandTiming commands;                ///< how long a command holds
  LineEnergyOptions energy;              ///< how the energy is counted
  Duration idle_after{1'000'000'000};    ///< without a command for so long the device is shut down
  Duration back_off{100'000'000};        ///< before the next attempt to connect; doubles until a cycle was good
  Duration back_off_max{2'000'000'000};  ///< the longest
  int failures_before_reopen = 5;        ///< failed cycles in a row
  std::string thread_name = "link";      ///< of the thread; cut to 15 characters
  LineGuarding guarding;                 ///< where the loop is in another process
  /// The first thing that the thread does: takes its policy, and returns what the system refused, in words. Empty: it
  /// takes over the policy of the loop's thread.
  std::function<std::vector<std::string>()> begin;
  FlightWriter flight;  ///< is told each cycle and each failure
};

/// Opens a Link and keeps it open, on a thread of its own, which drives the LineCycle: one command and one sample a
/// cycle, at absolute deadlines; cycles that are due while one is under way are skipped. A device that sets the pace is
/// waited for instead, and no more than one and a half periods ahead of the deadlines. Where a thread of the device's
/// library calls back, that one drives the cycles, and this one watches that samples keep coming.
///
/// The thread takes over the policy that the loop's thread has at its first command, one priority below it where that
/// is a real-time one: the loop goes before its line, and a graph that gives the loop less gives the line less too.
///
/// The command is cut from every opening of the line on, and where it grows too old (see CommandChannel). The loop sees
/// a cut by `cuts`, disengages, and engages anew by its ramp, so a force never comes back at once.
///
/// A line that fails failures_before_reopen times in a row, or says that it is of no use, is closed and opened again,
/// with a pause that doubles from attempt to attempt, also where it opens and then has no good cycle. Without any
/// command for idle_after the device is shut down and the line closed; a new command opens it.
class LinkRunner final : public DeviceLine {
 public:
  /// Throws InputError as `check` of the limits does.
  LinkRunner(std::unique_ptr<Link> link, const AxisLimits& limits, LinkRunnerSettings settings);
  ~LinkRunner() override;

  /// Makes the thread; the line is opened there.
  void start() override;
  void stop() override;

  bool newest(LinkReport& report) noexcept override { return cycle_.newest(report); }
  void command(Instant now, const LinkCommand& command) noexcept override;
  [[nodiscard]] Pace* pace() override { return link_->pace() == LinkPace::deadlines ? nullptr : &cycle_.pace(); }

  [[nodiscard]] const LinkMetrics& metrics() const override { return cycle_.metrics(); }
  [[nodiscard]] std::string last_failure() const override { return cycle_.last_failure(); }
  [[nodiscard]] std::vector<std::string> refused() const override;
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  void run();
  bool open();
  bool back_off();  // pauses; false: it is to stop
  void take_first_policy();
  void take_policy();
  void exchange(Instant began);
  void watch();
  [[nodiscard]] bool has_idled() const;
  void wait_idle();
  void shut_down();
  bool pause(Duration length);  // false: it is to stop
  [[nodiscard]] bool stopping() const { return stop_.load(std::memory_order_acquire); }

  std::unique_ptr<Link> link_;
  const LinkRunnerSettings settings_;
  const std::string name_;
  LineCycle cycle_;
  InheritedPolicy policy_;

  // The thread's.
  bool is_open_ = false;
  int failures_in_a_row_ = 0;
  bool any_good_ = false;  // since it was opened
  Duration back_off_;
  std::uint64_t sessions_ = 0;
  std::uint64_t watched_samples_ = 0;
  Instant sampled_;  // when the newest of them was seen

  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;  // of what follows; the loop never takes it
  std::condition_variable wake_;
  std::vector<std::string> refused_;
  std::thread thread_;
};

}  // namespace tactor
