// The cycles of a line, whichever thread drives them: the command that is due, and the report of what came.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "devices/hardware/axis_gate.hpp"
#include "devices/hardware/axis_limits.hpp"
#include "devices/hardware/command_channel.hpp"
#include "devices/hardware/link.hpp"
#include "devices/hardware/plausibility.hpp"
#include "framework/node/edge_queue.hpp"
#include "framework/realtime/flight_ring.hpp"
#include "framework/realtime/line_energy.hpp"
#include "framework/realtime/loop_statistics.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/pace.hpp"

namespace tactor {

/// What the loop learns of the line: plain data, since it may cross a process.
struct LinkReport {
  LinkSample sample;          ///< the newest; `verdict` says whether it is believed
  Instant sampled;            ///< when its cycle began, so that its age is not made smaller than it is
  std::uint64_t samples = 0;  ///< samples so far; 0: `sample` is not set
  Plausibility::Verdict verdict = Plausibility::Verdict::good;  ///< of `sample`
  Plausibility::Finding finding;                                ///< where it is not good
  AxisLimits limits;                                            ///< those of the node and of the line, the tighter ones
  std::uint64_t cuts = 0;             ///< how often the command was cut to zero, see CommandChannel
  std::uint64_t expiries = 0;         ///< how often it expired
  LineTotals energy;                  ///< on the line
  GateHold hold = GateHold::none;     ///< why the line's own gate holds the efforts back
  LinkError error = LinkError::none;  ///< of the newest cycle or attempt to connect
  bool asks_user = false;             ///< as LinkFailure has it
  std::array<char, 240> text{};       ///< why, in words, with the device's name
};
static_assert(std::is_trivially_copyable_v<LinkReport> && std::is_trivially_copyable_v<LinkCommand>);

/// Metrics of a line. Its thread writes them, any thread may read them meanwhile.
struct LinkMetrics {
  LoopCounter cycles;         ///< good ones
  LoopCounter forced_cycles;  ///< those whose command was an effort other than zero
  LoopCounter expired;        ///< cycles that were given zero for a command that had expired
  LoopCounter limited;        ///< cycles whose efforts were shortened to the limits of the axes
  LoopCounter reconnects;
  LoopCounter skipped;  ///< cycles that were due in another
  LoopCounter jumps;    ///< of encoders
  LoopCounter stuck;    ///< times that an encoder stood still under a force
  LatencyHistogram cycle_time;
  std::array<LoopCounter, link_error_count> by_error;

  [[nodiscard]] std::int64_t errors(LinkError error) const { return by_error[static_cast<std::size_t>(error)].value(); }
};

/// What the thread of a line writes while others read. It may lie in memory that two processes share.
struct LineBoard {
  explicit LineBoard(bool between_processes = false) : pace(between_processes) {}
  LinkMetrics metrics;
  Pace pace;  ///< a beat with each sample
};

class LineCycle;

/// A loop in another process, as the thread that drives the cycles sees it. Nothing in it waits or allocates.
class LineOutside {
 public:
  virtual ~LineOutside() = default;
  /// Before the command that is due is looked up: what has come goes to LineCycle::pass_on.
  virtual void admit(Instant now, LineCycle& cycle) noexcept = 0;
  /// The command that the device is to get.
  virtual void given(const LinkCommand& command) noexcept = 0;
  /// It has got the command that was given last.
  virtual void delivered() noexcept = 0;
  virtual void publish(const LinkReport& report) noexcept = 0;
};

/// What a LineCycle has in addition where its loop is in another process.
struct LineGuarding {
  LineOutside* outside = nullptr;      ///< null: the loop is a thread of this process
  LineBoard* board = nullptr;          ///< null: the cycle's own
  std::optional<AxisGateLimits> gate;  ///< absent: no gate of its own
};

/// What is handed over between a device loop and the line, and what each cycle does with it: the command that is due
/// passes the limits of the axes, the gate where there is one, and the bound on the energy; a sample is judged,
/// unwrapped, counted and reported. The loop never waits, allocates or locks.
///
/// One thread drives the cycles at a time: a LinkRunner's, or that of a device's library by `turn`.
class LineCycle final : public LinkTurn {
 public:
  /// `name` of the link, `ours` the limits of the axes as the node knows them; each cycle is told to `flight`. Throws
  /// InputError as `check` does.
  LineCycle(std::string name, const AxisLimits& ours, const CommandTiming& timing, const LineEnergyOptions& energy,
            const LineGuarding& guarding = {}, const FlightWriter& flight = {});

  // The device loop.

  /// The newest report; false, and nothing copied, where there is none since the last call. Wait-free.
  bool newest(LinkReport& report) noexcept;
  /// The command from now on. Wait-free.
  void command(Instant now, const LinkCommand& command) noexcept;
  /// A beat with each sample.
  [[nodiscard]] Pace& pace() { return board_->pace; }

  // The thread that drives.

  /// From LineOutside::admit: a command of a loop in another process, which commanded zero last at `zeroed`.
  void pass_on(Instant commanded, const LinkCommand& command, Instant zeroed) noexcept;
  /// Lets commands of another process in; without such a process nothing happens.
  void admit(Instant now) noexcept;

  /// The line has been opened: the command is cut. False, with why, where the two workspaces have no place in common.
  bool opened(const LinkLimits& theirs, LinkFailure& failure);
  /// What the device is to do in a cycle that begins now.
  LinkCommand due(Instant now);
  /// What came in the cycle that began at `began`; `fault` has the words for `sample.faults`.
  void took(Instant began, const LinkSample& sample, std::string_view fault);
  LinkCommand turn(const LinkSample& sample, std::string_view fault) override;
  void failed(const LinkFailure& failure) override;

  // Any thread.

  /// When the loop gave its newest command; zero: it has given none.
  [[nodiscard]] Instant commanded() const { return {commanded_ns_.load(std::memory_order_acquire)}; }
  /// Good cycles so far.
  [[nodiscard]] std::uint64_t samples() const { return samples_.load(std::memory_order_acquire); }
  /// When the driving thread last told of a sample of a callback, or of a failure.
  [[nodiscard]] Instant called() const { return {called_ns_.load(std::memory_order_acquire)}; }
  /// True from a failure that says so until the line is opened.
  [[nodiscard]] bool wants_reopen() const { return wants_reopen_.load(std::memory_order_acquire); }
  [[nodiscard]] LinkMetrics& metrics() { return board_->metrics; }
  [[nodiscard]] const LinkMetrics& metrics() const { return board_->metrics; }
  /// The newest failure in words, with the device's name; empty: none.
  [[nodiscard]] std::string last_failure() const;

 private:
  void publish();
  void tell_flight(LinkError error);

  const std::string name_;
  const AxisLimits ours_;
  CommandChannel commands_;
  EdgeQueue reports_{sizeof(LinkReport), alignof(LinkReport), Queue{}};
  std::unique_ptr<LineBoard> own_board_;
  LineBoard* const board_;
  LineOutside* const outside_;
  std::atomic<std::int64_t> commanded_ns_{0};

  // Of the thread that drives.
  Plausibility plausibility_;
  const Duration delay_in_;
  LineEnergy energy_;
  std::optional<AxisGate> gate_;
  AxisValues effort_{};  // given last
  LinkReport report_;
  Instant turned_;  // since the line was opened
  const FlightWriter flight_;
  Instant given_;            // when the cycle under way began; zero: there is none
  FlightExchange exchange_;  // of that cycle

  std::atomic<std::uint64_t> samples_{0};
  std::atomic<std::int64_t> called_ns_{0};
  std::atomic<bool> wants_reopen_{false};
  mutable std::mutex mutex_;  // of what follows; the loop never takes it
  std::string last_failure_;
};

}  // namespace tactor
