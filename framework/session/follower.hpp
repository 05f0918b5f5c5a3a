// A reference beside a live run: what the run should display, and how far it is from that, during the run.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "framework/realtime/monotonic_clock.hpp"
#include "framework/session/follower_plan.hpp"
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
  /// A message of the run that is to be fed.
  struct Waiting {
    Stamp stamp;
    std::size_t feed = 0;
    std::vector<std::byte> value;
    bool after_loss = false;  // messages before it were lost on their way
  };

  void run();
  void make_session();
  void begin_at(const Waiting& first);
  void take_in();
  void take_fed();
  void go_along(const Waiting& next);
  void begin_anew();
  void skip();
  void tell();

  Session& tested_;
  const FollowerPlan plan_;
  const std::optional<Duration> most_behind_;
  std::vector<std::unique_ptr<Session::OutputTap>> taps_;  // as plan_.fed
  std::unique_ptr<Session::OutputTap> judged_, stop_;

  // The following thread's.
  std::unique_ptr<Session> session_;
  std::vector<Session::Feed> feeds_;
  Time base_;  // time zero of `session_`, by the run's clock
  std::deque<Waiting> waiting_;
  std::vector<std::uint64_t> next_;  // by tap: the sequence that comes next; 0: none has come
  Time complete_until_;              // of the waiting
  Time newest_, reached_;
  std::optional<Time> stopped_;  // when the devices began to ramp down
  bool begun_ = false;
  RunningError error_;
  std::optional<FeltLately> felt_;
  Instant felt_at_;
  Duration skipped_;
  std::uint64_t skips_ = 0;

  std::thread thread_;
  std::function<void(Time, const Wrench&)> take_reference_;
  std::atomic<bool> count_anew_{false};
  std::atomic<bool> ended_{false};
  std::atomic<bool> finishing_{false}, finished_{false};
  mutable std::mutex mutex_;  // over `figures_`
  FollowerFigures figures_;
};

}  // namespace tactor
