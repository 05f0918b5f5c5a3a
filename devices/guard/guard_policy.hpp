// The scheduling policy of the guard's thread: the best one that the system grants.
#pragma once

#include <string>
#include <vector>

#include "framework/core/time.hpp"

namespace tactor {

/// Gives the calling thread `name` and SCHED_DEADLINE, of which it may use three tenths of each `period`; where that is
/// refused, SCHED_FIFO, and where that is refused too, SCHED_OTHER as apply_thread_settings gives it. Returns a line
/// for each refusal, with the policy that it got in the end; empty where it got the first.
std::vector<std::string> take_guard_policy(Duration period, const std::string& name);

}  // namespace tactor
