// The flight recorder of a live run: whether there is one, and what it is told beside the loops.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "framework/engine/live/finite_watch.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/realtime/crash_note.hpp"
#include "framework/realtime/flight_file.hpp"

namespace tactor {

/// Records the last minute of the run where `live.flight` says so; else nothing in it does anything. It outlives the
/// nodes, whose lines write into its ring.
class LiveFlight {
 public:
  explicit LiveFlight(const Plan& plan);

  /// Why there is none although one is wanted; empty: nothing is wrong.
  [[nodiscard]] const std::string& refused() const { return refused_; }
  /// Null where nothing is recorded.
  [[nodiscard]] FlightRing* ring() { return file_ ? &file_->ring() : nullptr; }
  [[nodiscard]] FlightFile* file() { return file_ ? &*file_ : nullptr; }

  /// Time zero of the run. From here on a crash is told too.
  void start(Instant origin);
  /// A step of a node outside of the real-time lane has ended, and what it sent still waits in its outputs. On the
  /// thread of the step.
  void stepped(std::size_t node, PlanNodes& nodes);
  /// A look at a node: whether its step, begun at `begun` of the run, has stalled. One thread at a time.
  void watch(std::size_t node, bool stalled, Time begun);
  void set(const SetEvent& event);
  /// The run fails, because of a node where one is named.
  void failed(const std::string& why, std::optional<std::size_t> node);
  void end(bool failed);

 private:
  const Plan& plan_;
  std::string refused_;
  std::optional<FlightFile> file_;
  std::optional<CrashNote> crash_;
  std::vector<FiniteWatch> watches_;  // by node
  std::vector<bool> stalled_;         // by node
};

}  // namespace tactor
