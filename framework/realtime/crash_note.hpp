// The last word of a process that crashes: which signal, and in which node.
#pragma once

#include <cstddef>

#include "framework/realtime/flight_ring.hpp"

namespace tactor {

/// While it lives, the signals of a crash (SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT) put an event into the ring before
/// they do as they did before: handlers of others keep their turn, and a core is still written. One that another
/// process sent goes straight to the handler from before, where there is one. A thread whose stack has run over has no
/// room for that, and ends without the event. At most eight at a time; a further one does nothing.
class CrashNote {
 public:
  explicit CrashNote(FlightRing& ring);
  ~CrashNote();
  CrashNote(const CrashNote&) = delete;
  CrashNote& operator=(const CrashNote&) = delete;

 private:
  FlightRing& ring_;
};

/// While it lives, the calling thread steps that node, by its index into the plan; a crash on the thread names it.
class SteppingNode {
 public:
  explicit SteppingNode(std::size_t node) noexcept;
  ~SteppingNode();
  SteppingNode(const SteppingNode&) = delete;
  SteppingNode& operator=(const SteppingNode&) = delete;

 private:
  const std::size_t before_;
};

}  // namespace tactor
