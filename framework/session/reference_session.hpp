// The session of a follower: the reference under the virtual clock, fed with what the run under test showed.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "framework/session/followed_run.hpp"
#include "framework/session/follower_plan.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// All times are by the clock of the run under test, whenever the session began.
class ReferenceSession {
 public:
  /// `plan` outlives it. `take` is called with each true force, during `feed`.
  ReferenceSession(const FollowerPlan& plan, std::function<void(Time, const Wrench&)> take);
  ReferenceSession(const ReferenceSession&) = delete;
  ReferenceSession& operator=(const ReferenceSession&) = delete;

  /// Makes the session again, from its initial state. `begin_at` follows.
  void restart();
  /// The first sample that it is fed is valid at `first`.
  void begin_at(Time first);
  /// Goes on to the time at which the message was produced, and feeds it.
  void feed(const FollowedMessage& message);

 private:
  const FollowerPlan& plan_;
  const std::function<void(Time, const Wrench&)> take_;
  std::unique_ptr<Session> session_;
  std::vector<Session::Feed> feeds_;  // as FollowerPlan::fed
  Time base_;                         // time zero of `session_`, by the run's clock
};

}  // namespace tactor
