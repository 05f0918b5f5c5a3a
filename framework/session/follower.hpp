// A reference beside a live run: what the run should display, and how far it is from that, during the run.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "framework/realtime/monotonic_clock.hpp"
#include "framework/session/followed_run.hpp"
#include "framework/session/follower_plan.hpp"
#include "framework/session/reference_session.hpp"
#include "framework/session/running_error.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// How far the follower has come.
struct FollowerFigures {
  ErrorFigures error;
  std::optional<FeltLately> felt;      ///< looked at four times a second
  Duration behind;                     ///< how far it is behind the run, as far as the run is known
  Duration skipped;                    ///< of the run, because the machine was too slow; with the time for settling
  std::uint64_t skips = 0;             ///< how often
  std::uint64_t dropped = 0;           ///< messages of the run that were lost on their way
  std::optional<std::string> failure;  ///< why it has stopped following
};

/// A second session, under the virtual clock, that is fed with the device samples of the first. Its physics makes one
/// step for each sample and costs no time of the run, so its force is the reference. It only taps the first session and
/// does not change it otherwise.
///
/// If it falls behind by more than `most_behind`, or if messages were lost on their way, it skips. It drops the samples
/// that it has not followed, restarts at the newest sample with the tool at the handle, and compares nothing for 0.3 s,
/// in which the reference settles. It reports the skipped time.
class Follower {
 public:
  static constexpr Duration settling{300'000'000};
  static constexpr Duration usual_most_behind{500'000'000};

  struct Options {
    std::optional<Duration> most_behind = usual_most_behind;  ///< none: it never skips
    /// The plan whose sink compares, if the session's plan has none; otherwise the same nodes. Null: the session's.
    const Plan* judged_by = nullptr;
  };
  /// Before or after the start of `tested`, which outlives the follower, on its thread. Throws InputError as
  /// plan_follower.
  Follower(Session& tested, Registry& registry, const Options& options);
  Follower(Session& tested, Registry& registry) : Follower(tested, registry, Options{}) {}
  /// Ends its thread.
  ~Follower();
  Follower(const Follower&) = delete;
  Follower& operator=(const Follower&) = delete;

  /// Follows on a thread of its own, which yields to all other threads. Throws RunError if no thread can be
  /// started.
  void start();
  /// Follows the messages that have come so far, and returns; instead of `start`. Throws RunError if a step throws.
  void follow();
  /// Ends the thread after it has followed the messages that have come, within at most `patience`.
  void finish(Duration patience);
  /// Any thread: the error counts only from now on, such as after a change of the method.
  void count_anew() { count_anew_ = true; }
  /// Any thread.
  [[nodiscard]] FollowerFigures figures() const;
  /// Called with each true force, by the clock of the run, on the thread that follows. Before `start` or `follow`.
  void on_reference(std::function<void(Time, const Wrench&)> take) { take_reference_ = std::move(take); }

 private:
  void run();
  void begin_at(const FollowedMessage& first);
  void begin_anew();
  void tell();

  const FollowerPlan plan_;
  const std::optional<Duration> most_behind_;

  // The following thread's.
  RunningError error_;
  std::function<void(Time, const Wrench&)> take_reference_;
  FollowedRun tested_;
  ReferenceSession reference_;
  bool begun_ = false;
  Time reached_;
  FollowerFigures latest_;
  Instant felt_at_;

  std::thread thread_;
  std::atomic<bool> count_anew_{false};
  std::atomic<bool> ended_{false};
  std::atomic<bool> finishing_{false}, finished_{false};
  mutable std::mutex mutex_;  // over `figures_`
  FollowerFigures figures_;
};

}  // namespace tactor
