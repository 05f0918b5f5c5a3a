// A session: one interface to a run, for both clocks. The command, the view and Python all use it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/engine/engine.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

struct SessionOptions {
  EngineOptions engine = {};
  /// The log of a live run of the same plan, which is made again under the virtual clock; it outlives the session.
  const RunLog* replay = nullptr;
  /// Its nodes may write files of their own, such as the table of an experiment. If false, they get the parameters of
  /// a replay (Declare::in_replay), so a run that only measures or draws a graph leaves no trace. Outside of a replay,
  /// a note (PlanNodes::notes) names each value of the graph that is ignored.
  bool keeps_tables = false;
};

/// The place of an output in a plan: the index of its node, and its index among the node's outputs.
struct PlannedOutput {
  std::size_t node = 0;
  std::size_t output = 0;
};
/// The output of that name (`coupling.force`). Throws InputError where the plan has none, with the reason where its
/// node was left out.
PlannedOutput find_output(const Plan& plan, std::string_view name);
/// The type of its messages.
inline const MessageType& type_of(const Plan& plan, const PlannedOutput& at) {
  return *plan.nodes[at.node].info->outputs[at.output].type;
}

/// A run of a plan that its owner can watch and control.
///
/// Under the virtual clock, the run proceeds only in `advance`, which makes the steps of that much time. The steps are
/// the same for any division into advances. With `clock: real` the run proceeds by itself, and `advance` waits.
///
/// Used by one thread at a time, and each call may come from another one. A tap may be read beside them.
class Session {
  class Run;

 public:
  /// Makes the nodes. Throws YamlError with the node's place if a node refuses its input, and like LiveLibrary::make.
  explicit Session(Plan plan, const SessionOptions& options = {});
  /// Ends a running run. If a step never came back, the run and its thread are left behind.
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  [[nodiscard]] const Plan& plan() const;
  [[nodiscard]] PlanNodes& nodes();

  /// A tap that ends with the object. It must not outlive the session.
  class OutputTap {
   public:
    OutputTap(Session& session, const MessageType& type, Queue queue) : session_(session), tap_(type, queue) {}
    OutputTap(const OutputTap&) = delete;
    OutputTap& operator=(const OutputTap&) = delete;
    ~OutputTap() { session_.end_tap(tap_); }
    /// See Tap. On one thread.
    [[nodiscard]] MessageView take() { return tap_.take(); }
    [[nodiscard]] const MessageType& type() const { return tap_.type(); }
    [[nodiscard]] std::uint64_t dropped() const { return tap_.dropped(); }

   private:
    friend class Session;
    Session& session_;
    Tap tap_;
  };

  /// The messages of an output (`coupling.force`) of any node of the plan, from now on; before the start or during the
  /// run. Throws InputError if the queue is too large, or the plan has no such output, with the reason if it left it
  /// out.
  [[nodiscard]] std::unique_ptr<OutputTap> tap(std::string_view output, Queue queue = {QueuePolicy::drop_oldest, 1024});

  /// The StopEvent, after which devices ramp down and sinks get no more messages; live, and in a replay.
  [[nodiscard]] std::unique_ptr<OutputTap> tap_stop();

  /// Takes a message of an output or of the engine, on the session's thread.
  using Take = std::function<void(const Stamp& stamp, const void* value)>;
  /// Identifies a subscription that on_message has begun.
  enum class Subscribed : std::uint64_t {};
  /// Calls `take` for each message of an output until `end_messages` or the session ends, during `advance` and
  /// `finish`. Under the virtual clock no message is lost. Live, up to `bytes` wait for `take`; messages beyond that
  /// are lost and counted. An exception of `take` ends a live run as its failure; under the virtual clock it passes
  /// through `advance`.
  Subscribed on_message(std::string_view output, Take take, std::size_t bytes = std::size_t{2} << 20U);
  /// Stops calling that `take`, and releases it and the waiting messages. Not to be called within a `take`.
  void end_messages(Subscribed subscribed);
  /// The same for each step, as a StepEvent.
  void on_step(Take take, std::size_t bytes = std::size_t{2} << 20U);
  /// The same for each tick of a node in the real-time lane, as a TickEvent; live only.
  void on_tick(Take take, std::size_t bytes = std::size_t{2} << 20U);
  /// The same for the StopEvent; live, and in a replay.
  void on_stop(Take take);
  /// The same for each change of parameters, as a SetEvent.
  void on_set(Take take);
  /// The number of messages and steps that were lost in this way.
  [[nodiscard]] std::uint64_t dropped() const;

  /// Sends messages into the run by an output of a fed node.
  class Feed {
   public:
    [[nodiscard]] const MessageType& type() const { return *type_; }
    /// Sends a message of `type`, valid at `valid`, or now if that is empty. It becomes visible now. Returns false and
    /// sends nothing if an edge of policy `block` has no room; a node would not step then either. Live: any thread.
    [[nodiscard]] bool send(const void* value, std::optional<Time> valid = {});
    template <Message T>
    requires(!std::is_pointer_v<T>) [[nodiscard]] bool send(const T& value, std::optional<Time> valid = {}) {
      TACTOR_DEMAND(same_type(*type_, message_type<T>()));
      return send(static_cast<const void*>(&value), valid);
    }

   private:
    friend class Session;
    Feed(Run& run, const PlannedOutput& at, const MessageType& type) : run_(&run), at_(at), type_(&type) {}
    Run* run_;
    PlannedOutput at_;
    const MessageType* type_;
  };
  /// The feed of a node that has one output (`hand`), of an output (`physics.state`), or of the input that a feed fills
  /// (`device.target`). Throws InputError if there is none.
  [[nodiscard]] Feed feed(std::string_view name);
  /// Sends several messages of a fed node at once (see Engine::feed). Live: any thread.
  [[nodiscard]] bool send(std::size_t node, std::optional<Time> valid, std::span<const FedValue> values);
  /// Calls `read` with a fed node while no message reaches its inputs, so that it may take those that wait there. Live,
  /// all nodes outside of the real-time lane wait meanwhile.
  void read_inputs(std::size_t node, const std::function<void(Node&)>& read);
  /// Gives the inputs of a fed node to the caller for the whole session; false where somebody has them.
  [[nodiscard]] bool claim_inputs(std::size_t node);

  /// Sets a tunable parameter while the session runs, from text as in a graph file: set("coupling.k_0", "1200 N/m").
  /// It takes effect from the node's next step on. Throws InputError if the value is refused or the parameter is not
  /// tunable; then nothing changes.
  void set(std::string_view parameter, std::string_view value);

  /// The run ends when `asked` returns true (see Engine::stop_when). Call it before the start.
  void stop_when(std::function<bool()> asked);

  [[nodiscard]] bool is_started() const;
  /// Begins the run, at time zero. Throws, before anything moves, if a device or a privilege is refused. Once.
  void start();
  /// Lets `duration` of the run pass, but not beyond its end. Throws RunError if a step of the virtual clock throws.
  void advance(Duration duration);
  /// False if the run has come to its end, was stopped or has failed.
  [[nodiscard]] bool is_running();
  /// The time up to which it has run.
  [[nodiscard]] Time now();
  /// The state now; after `finish` that at the end of the run.
  [[nodiscard]] EngineStatus status();
  /// Ends the run at once; live, the devices ramp down in `finish`. Live: from any thread, at any time from the start
  /// to the end of `finish`.
  void stop();
  /// Ends the run if it is still running, and everything that belongs to it. Its nodes and metrics stay. Once.
  void finish();
  /// Starts if it has not, lets the run go on to its end, and finishes. Calls `meanwhile` after each `slice` of the
  /// run. `meanwhile` may stop the session. What it throws passes through once the run has finished.
  void run(Duration slice, const std::function<void()>& meanwhile);

  // After `finish`, and for the virtual clock before.

  /// Live: why it ended before its time, with the node's name.
  [[nodiscard]] std::optional<std::string> failure() const;
  /// Live: true if a step never came back. Its thread still uses the nodes, so they cannot be asked.
  [[nodiscard]] bool is_abandoned() const;
  [[nodiscard]] NodeStatistics node_statistics(std::size_t node) const;
  /// See Engine; empty for a node in the real-time lane.
  [[nodiscard]] std::vector<Duration> step_times(std::size_t node) const;
  [[nodiscard]] EdgeStatistics edge_statistics(std::size_t edge) const;
  [[nodiscard]] Duration cpu_time() const;
  /// Live, at any time: the file of the flight recorder; null where there is none.
  [[nodiscard]] FlightFile* flight();

 private:
  void end_tap(const Tap& tap);

  std::unique_ptr<Run> run_;
};

}  // namespace tactor
