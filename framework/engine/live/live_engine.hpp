// The live engine without what it is made of: what runs a Plan in real time, and the library that brings it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "framework/engine/live/live_status.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/tap.hpp"

namespace tactor {

/// A run of a plan whose clock is real.
class LiveEngine {
 public:
  /// Must not be called where the run `is_abandoned`.
  virtual ~LiveEngine() = default;

  /// As Dispatcher::add_tap and the others. Before the start or while it runs, from any thread.
  virtual void add_tap(std::size_t node, std::size_t output, Tap& tap) = 0;
  virtual void add_step_tap(Tap& tap) = 0;
  virtual void add_tick_tap(Tap& tap) = 0;
  virtual void add_stop_tap(Tap& tap) = 0;
  virtual void remove_tap(const Tap& tap) = 0;

  /// A message of the fed node `node`, valid at `valid`, or now if that is empty; false, and nothing is sent, where
  /// an edge of policy `block` has no room. While it runs, any thread.
  virtual bool feed(std::size_t node, std::optional<Time> valid, const void* value) = 0;
  /// New parameters for the node, from its next step on; the time from which they hold. While it runs, any thread.
  virtual Time tune(std::size_t node, std::shared_ptr<const void> params) = 0;
  /// True if no step of the node still runs with older parameters than the last ones. While it runs, any thread.
  [[nodiscard]] virtual bool is_tuned(std::size_t node) = 0;

  /// Sets a question whose yes ends the run. It is asked about fifty times a second on a thread of the engine and does
  /// not wait for anything: it ends the run even while a disk or a terminal keeps the calling thread. Before `start`.
  virtual void stop_when(std::function<bool()> asked) = 0;

  /// Lets the run begin, and returns. Throws where nothing has moved, because a thread or a device was refused. Once.
  virtual void start() = 0;
  /// False from when the graph's duration has passed, the run was stopped, or something has failed.
  [[nodiscard]] virtual bool is_running() = 0;
  /// Ends the run now; `why` is its failure, where it is not empty. Any thread.
  virtual void stop(const std::string& why) = 0;
  /// The state now, with latencies so far. While it runs.
  [[nodiscard]] virtual LiveStatus look() = 0;
  /// Ends the run where it goes on, lets the devices ramp down, and ends everything. Meanwhile it calls
  /// `while_waiting` about fifty times a second, and once after the last message. Once.
  virtual void finish(const std::function<void()>& while_waiting) = 0;

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
extern "C" const tactor::LiveLibrary* tactor_live_library();
