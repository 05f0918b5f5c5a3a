// How the steps of a node are scheduled when the clock is real: its lane, its thread, and the thread's policy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "framework/core/time.hpp"

namespace tactor {

/// Where a node steps when the clock is real.
enum class Lane : std::uint8_t {
  pool,      ///< light nodes: a few workers that all of them share
  thread,    ///< heavy nodes: a thread of its own, or one shared by the nodes that name the same thread
  realtime,  ///< devices: an exclusive loop with absolute deadlines
};

/// A scheduling policy of the operating system.
enum class SchedulingPolicy : std::uint8_t {
  other,        ///< SCHED_OTHER: fair shares
  fifo,         ///< SCHED_FIFO: runs until it waits or a higher priority comes
  round_robin,  ///< SCHED_RR: as fifo, in turns among equal priorities
};

/// What a thread asks of the operating system.
struct ThreadSettings {
  SchedulingPolicy policy = SchedulingPolicy::other;
  int priority = 0;        ///< 1 to 99 for fifo and round_robin, 0 for other
  std::optional<int> cpu;  ///< the core it is pinned to; absent: any

  bool operator==(const ThreadSettings&) const = default;
};

/// How one node is scheduled. Nodes of one thread have the same policy, priority and core.
struct Scheduling {
  Lane lane = Lane::pool;
  std::string thread;  ///< lane `thread`: nodes of the same name take turns on one thread; empty: alone
  std::optional<SchedulingPolicy> policy;  ///< absent in the pool, whose threads have theirs in LiveSettings
  std::optional<int> priority;             ///< 1 to 99 for fifo and round_robin, absent for other
  std::optional<int> cpu;                  ///< absent: any core

  bool operator==(const Scheduling&) const = default;
};

/// What happens if a privilege for real time is missing.
enum class OnMissingPrivilege : std::uint8_t {
  warn,  ///< run without it and warn
  fail,  ///< do not start
};

/// What happens if a step does not come back.
enum class OnStall : std::uint8_t {
  stop,     ///< the run ends, exit code 1
  recover,  ///< the force stays at zero until the step comes back, then ramps up again
};

/// Whether the last minute of a live run is kept by the flight recorder.
enum class FlightChoice : std::uint8_t {
  automatic,  ///< where hardware is driven; its file goes where the run ended well
  keep,       ///< always, and its file stays
  off,
};

/// How a graph runs when the clock is real.
struct LiveSettings {
  OnMissingPrivilege on_missing_privilege = OnMissingPrivilege::warn;
  OnStall on_stall = OnStall::stop;
  Duration stall_timeout{500'000'000};  ///< a step that takes longer has stalled
  bool impose_cost = false;             ///< results are held back until the declared cost of their step has passed
  FlightChoice flight = FlightChoice::automatic;
  int pool_workers = 0;  ///< threads of the pool; 0: chosen from the numbers of nodes and cores
  ThreadSettings pool{SchedulingPolicy::fifo, 50, std::nullopt};

  bool operator==(const LiveSettings&) const = default;
};

}  // namespace tactor
