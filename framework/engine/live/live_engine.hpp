// The live engine without what it is made of: what runs a Plan in real time, and the library that brings it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "framework/engine/live/live_status.hpp"
#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// A run of a plan whose clock is real.
class LiveEngine {
 public:
  /// Must not be called where the run `is_abandoned`.
  virtual ~LiveEngine() = default;

  /// Sets a question whose yes ends the run. It is asked about fifty times a second on a thread of the engine and does
  /// not wait for anything: it ends the run even while a disk or a terminal keeps the calling thread. Before `run`.
  virtual void stop_when(std::function<bool()> asked) = 0;

  /// Runs until the graph's duration has passed, `go_on` says no (asked about ten times a second, on the calling
  /// thread), or something fails; then lets the devices ramp down and ends everything. The observer is called on the
  /// calling thread and may be slow. Once only.
  virtual void run(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on) = 0;

  /// Why the run ended before its time, with the node's name; none where it did not fail.
  [[nodiscard]] virtual const std::optional<std::string>& failure() const = 0;
  /// True where a step never came back: its thread still uses this object, so only the end of the process may follow.
  [[nodiscard]] virtual bool is_abandoned() const = 0;

  [[nodiscard]] virtual PlanNodes& nodes() = 0;
  /// The state at the end.
  [[nodiscard]] virtual const LiveStatus& status() const = 0;
  /// CPU time of the steps of a node, in the pool of some of them; none for one in the real-time lane, which has its
  /// loop's metrics.
  [[nodiscard]] virtual const NodeStatistics& node_statistics(std::size_t node) const = 0;
};

/// The functions of the library of the live engine.
struct LiveLibrary {
  /// Makes the nodes of a plan, which must outlive the run. Throws InputError with the node's name where a node refuses
  /// its input, and where a node asks for a core that this machine does not have; RunError where the system refuses a
  /// privilege and the graph says `on_missing_privilege: fail`.
  std::unique_ptr<LiveEngine> (*make)(const Plan& plan);
};

/// Loads libtactor_live.so, once: a run under the virtual clock never loads the actor framework. Throws InputError
/// where it is not there: then the build has no live engine.
const LiveLibrary& load_live_library();

}  // namespace tactor

/// The one symbol that libtactor_live.so exports; null where the caller is of another build.
extern "C" const tactor::LiveLibrary* tactor_live_library(std::uint64_t abi);
