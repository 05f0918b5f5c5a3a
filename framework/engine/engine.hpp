// An engine: what runs a plan, by whichever clock, behind one interface.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "framework/engine/dispatcher.hpp"
#include "framework/engine/engine_status.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_events.hpp"

namespace tactor {

struct RunLog;
class FlightFile;

struct EngineOptions {
  /// Under the virtual clock: time every step by the thread's CPU clock.
  bool measure_cpu = false;
  /// Keep what each step of every node outside of the real-time lane took (see Engine::step_times). Under the virtual
  /// clock needs `measure_cpu`.
  bool keeps_step_times = false;
  /// Under the virtual clock: seconds of the run for a second of wall time; 0: as fast as it goes.
  double pace = 0;
  /// Under the virtual clock: is told of the work of each node (see NodeMeter), and outlives the engine; null: nobody.
  NodeMeter* meter = nullptr;
  /// Live: asks whether hardware may give a force though no button stops it when a person lets go, and the graph does
  /// not say so (`dead_man_button: 0`); called at most once, before anything moves. Null: it may not.
  Ask without_dead_man = {};
};

/// The owner's part in a run, done by the engine on the thread that calls `advance` and `finish`.
struct Attendance {
  /// Hands the messages that wait to their readers. May throw.
  std::function<void()> read = [] {};
  /// Does what nodes have asked for. Returns false if a request still waits until the setting before it is in force.
  /// May throw.
  std::function<bool()> serve = [] { return true; };
};

/// A message for one output of a fed node.
struct FedValue {
  std::size_t output = 0;       ///< index into NodeInfo::outputs
  const void* value = nullptr;  ///< of the output's type
};

/// A run of a plan, which must outlive it.
class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  /// Ends the run if it is still running. Not to be called if the run `is_abandoned`.
  virtual ~Engine() = default;

  /// Calls `work` with the dispatcher while no step changes it, to add or remove taps. Any thread; live at any time.
  virtual void with_dispatcher(const std::function<void(Dispatcher&)>& work) = 0;
  /// True if steps are made on the thread that calls `advance`: then a full tap may be read by its writer.
  [[nodiscard]] virtual bool steps_on_caller() const = 0;

  /// Sends messages of the fed node `node`, valid at `valid`, or now if that is empty. All become visible at one
  /// instant. Their outputs are in the order of NodeInfo::outputs, each at most once, so that a replay sends them in
  /// the same order. Returns false and sends nothing if an edge of policy `block` has no room. Live: any thread.
  virtual bool feed(std::size_t node, std::optional<Time> valid, std::span<const FedValue> values) = 0;
  /// Gives the node new parameters from its next step on, or tells it that a request is done if they are null, and
  /// tells `event`. Live: any thread.
  virtual void set(std::size_t node, std::shared_ptr<const void> params, const SetEvent& event) = 0;
  /// True if no step of the node still runs with older parameters than the last ones. Live: any thread.
  [[nodiscard]] virtual bool is_set(std::size_t node) = 0;

  /// The run ends when `asked` returns true. Live, a thread of the engine asks about fifty times a second and waits for
  /// nothing, so the run ends even while a disk or a terminal keeps the calling thread. Before `start`.
  virtual void stop_when(std::function<bool()> asked) = 0;

  /// Begins the run. Throws, before anything moves, if a device or a privilege is refused. Once.
  virtual void start() = 0;
  /// Lets `duration` of the run pass, but not beyond its end. Under the virtual clock, passes on what a step or
  /// `attendance` throws; live, an exception of `attendance` is the run's failure.
  virtual void advance(Duration duration, const Attendance& attendance) = 0;
  /// False if the run has come to its end, was stopped or has failed.
  [[nodiscard]] virtual bool is_running() = 0;
  /// The time up to which it has run.
  [[nodiscard]] virtual Time now() = 0;
  /// Ends the run now; `why` is its failure, if it is not empty. Live: any thread.
  virtual void stop(const std::string& why) = 0;
  /// Ends a running run. Live, lets the devices ramp down first, and attends about fifty times a second meanwhile.
  /// Once.
  virtual void finish(const Attendance& attendance) = 0;

  /// Live: why the run ended before its time, with the node's name.
  [[nodiscard]] virtual std::optional<std::string> failure() const { return std::nullopt; }
  /// Live: true if a step never came back. Its thread still uses this object, so only the end of the process may
  /// follow.
  [[nodiscard]] virtual bool is_abandoned() const { return false; }

  /// Live: the file of the flight recorder; null where there is none.
  [[nodiscard]] virtual FlightFile* flight() { return nullptr; }
  [[nodiscard]] virtual PlanNodes& nodes() = 0;
  /// The state now; after `finish` that at the end of the run, with histograms.
  [[nodiscard]] virtual EngineStatus status() = 0;
  /// CPU time of the steps of a node; live in the pool that of some of them, and none for a node in the real-time lane.
  [[nodiscard]] virtual NodeStatistics node_statistics(std::size_t node) const = 0;
  /// The time of each step of a node outside of the real-time lane, in order, if the options keep it. Under the virtual
  /// clock the CPU time of its thread; live the time until its results were visible, including waiting.
  [[nodiscard]] virtual std::vector<Duration> step_times(std::size_t node) const = 0;
  /// Step times that were lost, because `advance` was not called for long.
  [[nodiscard]] virtual std::uint64_t dropped() const { return 0; }
  /// Live: after `finish`.
  [[nodiscard]] virtual EdgeStatistics edge_statistics(std::size_t edge) const = 0;
  /// CPU time so far of the threads that make the steps: the calling one, or live those of the whole process.
  [[nodiscard]] virtual Duration cpu_time() const = 0;
};

/// Makes the nodes and the engine of the plan's clock. If `log` is not null, the engine makes that live run again under
/// the virtual clock; the log outlives the engine. Throws YamlError with the node's place if a node refuses its input.
/// Live, also throws InputError if there is no live engine or no such core, or hardware has no dead-man button and the
/// options do not do without one, and RunError if the graph insists on a
/// privilege that the system refuses.
std::unique_ptr<Engine> make_engine(const Plan& plan, const EngineOptions& options, const RunLog* log);

}  // namespace tactor
