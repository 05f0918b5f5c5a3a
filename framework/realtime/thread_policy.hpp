// Asks the operating system for the policy, priority and core of a thread, and tells what it gave.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "framework/core/scheduling.hpp"
#include "framework/realtime/privilege.hpp"

namespace tactor {

/// What a thread runs under after it has asked.
struct ThreadGrant {
  ThreadSettings granted;
  int nice = 0;                  ///< of SCHED_OTHER: -20 goes before all others, 19 after them
  std::vector<Refusal> refused;  ///< empty: everything was given
};

/// Gives the calling thread the policy, priority and core of `settings`, and `name` cut to 15 characters. Nothing
/// throws for a missing privilege; what falls short is in `refused`:
/// - a real-time policy at the highest priority that the limit allows, if that is lower; else SCHED_OTHER with the
///   lowest niceness that is allowed: beside busy programs a loop then misses about half as many deadlines;
/// - any core where the one asked for is not to be had.
/// Under SCHED_OTHER the timer slack becomes 1 ns, without which the kernel lets each sleep run 50 us over. Call it
/// before the loop: it allocates and reads files.
ThreadGrant apply_thread_settings(const ThreadSettings& settings, const std::string& name);

/// The calling thread gives way to all others of SCHED_OTHER from now on (nice 19).
void give_way();

/// The cores that a container, a service or `taskset` leaves to the calling thread, in order; none where the system
/// does not tell.
std::vector<int> usable_cores();

/// What would be refused to threads of these settings and to a MemoryLock, each told once. Tried on threads that end
/// at once, so that a graph with `on_missing_privilege: fail` can be refused before anything moves.
std::vector<Refusal> missing_privileges(std::span<const ThreadSettings> threads);

}  // namespace tactor
