// What a follower is told of the run under test: device samples in order of time, and the displayed force.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "framework/session/follower_plan.hpp"
#include "framework/session/running_error.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// A message of the run under test that is to be fed.
struct FollowedMessage {
  Stamp stamp;
  std::size_t feed = 0;  ///< index into FollowerPlan::fed
  std::vector<std::byte> value;
  bool after_loss = false;  ///< messages before it were lost on their way
};

/// Taps a session, which outlives it, and keeps the messages that are to be fed until they are taken.
class FollowedRun {
 public:
  FollowedRun(Session& tested, const FollowerPlan& plan);

  /// Reads what has come. Displayed forces go to `error`, up to the stop of the run.
  void read(RunningError& error);
  /// The next message to feed; null if an earlier one may still come.
  [[nodiscard]] const FollowedMessage* next() const;
  void pop() { waiting_.pop_front(); }
  /// Drops all that wait but the newest, which becomes `next`.
  void skip_to_newest();
  /// When the newest message was produced, by the clock of the run.
  [[nodiscard]] Time newest() const { return newest_; }
  /// Messages that were lost on their way.
  [[nodiscard]] std::uint64_t dropped() const;

 private:
  void read_fed();

  std::vector<std::unique_ptr<Session::OutputTap>> taps_;  // as FollowerPlan::fed
  std::unique_ptr<Session::OutputTap> judged_, stop_;
  std::deque<FollowedMessage> waiting_;
  std::vector<std::uint64_t> next_;  // by tap: the sequence that comes next; 0: none has come
  Time complete_until_;              // of the waiting
  Time newest_;
  std::optional<Time> stopped_;  // when the devices began to ramp down
};

}  // namespace tactor
