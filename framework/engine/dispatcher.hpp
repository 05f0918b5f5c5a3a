// Which node steps when, and what it sees: the semantics that the virtual and the real clock share.
//
// A node that steps at time t sees the messages that arrived by t. What it sends becomes visible when the step has
// passed; until then the node is busy and its triggers wait by the policies of their queues. A node with a rate that is
// still busy when its tick comes misses that tick. Nodes that share a thread never step at the same time. At one
// instant messages arrive first, then nodes step in the order of the plan; a node whose step has just passed steps anew
// after the others, so that it sees what they made of its results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "framework/engine/engine_status.hpp"
#include "framework/engine/held_messages.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_events.hpp"
#include "framework/engine/run_statistics.hpp"
#include "framework/engine/tap.hpp"
#include "framework/graph/chains.hpp"

namespace tactor {

/// Takes what is for nodes that step outside of the dispatcher, in a loop of their own.
class ExternalInputs {
 public:
  virtual ~ExternalInputs() = default;
  virtual void on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) = 0;
  virtual void on_phase(Phase phase) = 0;
};

/// The state of a run between its steps. It steps nothing itself: an engine asks `next_request` which node is to step,
/// steps it, and says `complete` when the step has passed. Used by one thread at a time; the step itself may be made on
/// another thread, because the inputs of a busy node are left alone.
class Dispatcher {
 public:
  /// A step to be made.
  struct StepRequest {
    std::size_t node = 0;
    Time now;
    Phase phase = Phase::running;
  };

  /// Connects the nodes. The nodes of `chains` step outside; what they send comes by `publish`, and `inputs` gets what
  /// is for them. On an inner edge that is only what they sent in `start`: after that their loop passes it on itself,
  /// and `publish` counts it. `nodes` and `inputs` must outlive the dispatcher.
  explicit Dispatcher(PlanNodes& nodes, Chains chains = {}, ExternalInputs* inputs = nullptr);

  /// The messages of an output from now on, as they become visible.
  void add_tap(std::size_t node, std::size_t output, Tap& tap);
  /// The messages that arrive at the input of an edge from now on.
  void add_arrival_tap(std::size_t edge, Tap& tap);
  /// A StepEvent for each step that passes from now on.
  void add_step_tap(Tap& tap) { step_taps_.push_back(&tap); }
  /// A TickEvent for each tick of a node in the real-time lane from now on.
  void add_tick_tap(Tap& tap) { tick_taps_.push_back(&tap); }
  /// A SetEvent for each change of parameters from now on.
  void add_set_tap(Tap& tap) { set_taps_.push_back(&tap); }
  /// A StopEvent.
  void add_stop_tap(Tap& tap) { stop_taps_.push_back(&tap); }
  /// Ends one of these.
  void remove_tap(const Tap& tap);

  /// Calls `start` of every node at time zero and delivers what they send. Once, before anything else.
  void start();

  [[nodiscard]] Time now() const { return now_; }
  [[nodiscard]] Phase phase() const { return phase_; }
  /// The state of the run, without what only a live engine knows.
  [[nodiscard]] EngineStatus status() const;
  /// Devices ramp down from now on, and sinks get nothing more.
  void stop(bool failed = false);

  /// The time of the next tick, delayed arrival or end of a step; none where nothing is due.
  [[nodiscard]] std::optional<Time> next_event() const;
  [[nodiscard]] bool has_event_at(Time t) const;
  /// Moves the time on, to no later than the next event.
  void move_to(Time t);
  /// Handles everything that is due at `now`.
  void handle_due();

  /// The next node that is to step at `now`; it is busy from here on. None where all wait.
  std::optional<StepRequest> next_request();
  /// The step of `node`, which has been made, has passed: what it sent becomes visible, what came meanwhile reaches its
  /// inputs, and it may step again.
  void complete(std::size_t node);
  /// The same at a later time.
  void complete_at(std::size_t node, Time t);
  /// The step of `node` has failed: it never steps again, but the others on its thread may.
  void failed(std::size_t node);
  /// True where a message of the node waits for room on an edge of policy `block`.
  [[nodiscard]] bool is_blocked(std::size_t node) const { return states_[node].blocked_edges > 0; }
  /// A tick of an external node, due at `deadline`, was told at `now`.
  void tell_tick(Time deadline, Time now, const TickEvent& event);
  /// A node has new parameters, which hold from `now` on.
  void tell_set(Time now, const SetEvent& event);
  /// An external node sent a message.
  void publish(std::size_t node, std::size_t output, Time valid, const void* payload);
  /// A step of an external node that began at `begun` has passed, and what it sent was published.
  void passed(std::size_t node, Time begun);

  [[nodiscard]] bool busy(std::size_t node) const { return states_[node].busy; }
  /// The steps that have begun.
  [[nodiscard]] std::uint64_t steps(std::size_t node) const { return states_[node].steps; }
  [[nodiscard]] std::uint64_t missed_ticks(std::size_t node) const { return states_[node].missed_ticks; }
  /// The messages that an output has sent.
  [[nodiscard]] std::uint64_t sent(std::size_t node, std::size_t output) const {
    return states_[node].sequence[output];
  }
  [[nodiscard]] EdgeStatistics edge_statistics(std::size_t edge) const;
  /// When the newest message that the reader of the edge sees became visible; none before the first.
  [[nodiscard]] std::optional<Time> newest_produced(std::size_t edge) const { return edges_[edge].newest_produced; }
  /// The edges that end at a node, in the order of the plan.
  [[nodiscard]] const std::vector<std::size_t>& edges_into(std::size_t node) const { return states_[node].edges_in; }

 private:
  struct NodeState {
    bool external = false;
    double rate = 0;  // Hz; 0: it steps on messages only
    std::int64_t next_tick = 0;
    std::optional<std::size_t> group;  // of nodes that share a thread
    bool busy = false;
    Time begun;          // when its last step began
    Time completed{-1};  // when it last became free
    bool tick_due = false;
    bool triggered = false;
    bool awaited = false;  // the run is not under way before its first step has passed
    int blocked_edges = 0;
    std::size_t unread_before = 0;  // of its trigger queues, when the step began
    std::uint64_t steps = 0;
    std::uint64_t missed_ticks = 0;
    std::vector<InputBase*> inputs;                   // by index into NodeInfo::inputs
    std::vector<InputBase*> trigger_queues;           // inputs whose unread messages ask for a step
    std::vector<OutputBase*> outputs;                 // by index into NodeInfo::outputs
    std::vector<std::uint64_t> sequence;              // by output
    std::vector<std::vector<std::size_t>> edges_out;  // by output
    std::vector<std::vector<Tap*>> taps;              // by output
    std::vector<HeldMessages> held;                   // by output: what becomes visible when the node is free again
    std::vector<std::size_t> edges_in;
  };
  struct EdgeState {
    explicit EdgeState(InputBase& reader) : input(&reader), delayed(reader.type()), blocked(reader.type()) {}
    InputBase* input;
    std::vector<Tap*> taps;
    bool to_sink = false;
    bool is_inner = false;            // of a chain
    HeldMessages delayed;             // in order of arrival
    HeldMessages blocked;             // waiting for room in a `block` queue
    std::size_t unread_at_begin = 0;  // of the reader's input, when its step began
    std::uint64_t delivered = 0;
    std::optional<Time> newest_produced;
  };
  struct Event {
    enum class Kind : std::uint8_t { arrival, complete, tick };
    Time time;
    std::uint64_t count = 0;  // ties of one kind are handled in the order of scheduling, which is deterministic
    Kind kind = Kind::tick;
    std::size_t index = 0;  // edge of an arrival, else node
  };
  struct Later {
    bool operator()(const Event& a, const Event& b) const;
  };

  void connect();
  void find_groups();
  void find_awaited();
  [[nodiscard]] bool ready(const NodeState& state) const;
  [[nodiscard]] bool is_next(const NodeState& state) const;
  void push_event(Time time, Event::Kind kind, std::size_t index);
  void schedule_tick(std::size_t node);
  void handle(const Event& event);
  void take_outputs(std::size_t node);
  void release(std::size_t node);
  void first_step_passed(NodeState& state);
  void set_phase(Phase phase);
  void tell_step(std::size_t node);
  void find_wanted(NodeState& state, std::size_t output);
  void deliver(std::size_t edge, const Stamp& stamp, const std::byte* payload);
  void arrive(std::size_t edge, const Stamp& stamp, const std::byte* payload);
  /// A message has reached a reader that steps outside.
  static void count(EdgeState& edge, const Stamp& stamp);
  void admit(std::size_t edge);
  void flush_blocked(std::size_t reader);

  PlanNodes& nodes_;
  const Plan& plan_;
  ExternalInputs* external_;
  std::vector<Tap*> step_taps_, tick_taps_, set_taps_, stop_taps_;
  std::uint64_t sets_ = 0;
  std::vector<NodeState> states_;
  std::vector<EdgeState> edges_;
  std::vector<char> group_busy_;
  std::vector<Event> events_;  // a heap, the earliest on top
  std::uint64_t event_count_ = 0;
  std::size_t awaited_ = 0;
  Phase phase_ = Phase::starting;
  Time now_;
};

}  // namespace tactor
