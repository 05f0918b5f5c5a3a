// A loop of physics that a program runs itself: what its next step needs, and where its result goes.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/engine_state.hpp"
#include "framework/core/handle_gate.hpp"
#include "framework/core/light_copy.hpp"
#include "framework/core/messages.hpp"
#include "framework/session/physics_coupling.hpp"
#include "framework/session/physics_messages.hpp"
#include "framework/session/session.hpp"

namespace tactor {

class PhysicsLoop;

/// What the next step of a program's physics needs.
struct PhysicsStep {
  Time begin;                         ///< of the sample of the handle that the last step ended with
  Time end;                           ///< of the newest sample, later than `begin`; the result holds for it
  DeviceState from;                   ///< the handle at `begin`
  DeviceState handle;                 ///< the handle at `end`
  CouplingParameters coupling;        ///< the spring and damper between handle and tool; zero where the graph has none
  const PhysicsLoop* loop = nullptr;  ///< that the step is of

  /// s
  [[nodiscard]] double h() const { return (end - begin).seconds(); }
  /// The handle at `t`, on the straight way from `begin` to `end`, for sub-steps; before and after, at its ends.
  [[nodiscard]] DeviceState handle_at(Time t) const;
};

/// Drives the node physics.external of a session. `next` waits for what the next step needs, and `result` sends what it
/// came to:
///
///     for (PhysicsLoop loop(session); const auto step = loop.next();) loop.result(*step, my_physics(*step));
///
/// Virtual clock: `next` advances the run to the next period of the node's `rate`, and a result becomes visible one
/// period after its step began. So the run has the same bytes however long the program takes. Real clock: the run goes
/// by itself, `next` waits at most until the next period begins, and a result becomes visible at once. A program that
/// stalls is late physics. Used on the session's thread; the session outlives it.
class PhysicsLoop {
 public:
  /// `node`: the one to drive; empty: the only one of type physics.external. Throws InputError where there is none or
  /// the name does not tell which, where the node has had a loop of this session already, and where an edge of policy
  /// `block` begins or ends there.
  explicit PhysicsLoop(Session& session, std::string_view node = {});
  PhysicsLoop(const PhysicsLoop&) = delete;
  PhysicsLoop& operator=(const PhysicsLoop&) = delete;
  /// The name of the node that a loop of the plan would drive. Throws InputError as the constructor does.
  [[nodiscard]] static std::string node_of(const Plan& plan, std::string_view node = {});

  /// Lets the graph go on between two results by a light copy of the program's own simulator: gives `step` to each node
  /// that reads the states of this physics, which are those of the types prediction.external and
  /// interpolation.external. CopyFunction says what a step may do. `numbers`: how many numbers its state has. From then
  /// on each result tells its `copy_state`; a graph without such nodes ignores them. Once, before the session starts.
  /// Throws InputError where it has started, at a second copy, at a state without numbers, and where such nodes find no
  /// coupling, because no edge ends at the node's `coupling`.
  ///
  ///     loop.rollout(2, [](std::span<double> state, const CopyStep& step) { ... return CopyTool{X_WT, V_WT}; });
  void rollout(std::size_t numbers, CopyFunction step);

  /// The next step; starts the session if nobody has. Empty: the run has ended. Throws as Session::advance does, and
  /// RunError where 100 samples of the handle have come and none can be used, and InputError where the graph
  /// reads states of a light copy and the program has given none. Throws RunError at the end of a run in which no
  /// sample of the handle came, if the hand is a feed that nobody filled.
  [[nodiscard]] std::optional<PhysicsStep> next();
  /// The same, but lets at most `longest` of the run pass; empty also where no step has begun by then.
  [[nodiscard]] std::optional<PhysicsStep> next_within(Duration longest);
  /// False once the run has ended.
  [[nodiscard]] bool is_running() { return !session_.is_started() || session_.is_running(); }

  /// Sends what `step` came to. A step may have several results, in the order of their times, or none. Throws
  /// ResultError as physics_messages does; where the step is of another loop; where the time is before that of the last
  /// result or of all samples of the handle that are kept, or later than now; and where the graph reads the node's
  /// `force`, `contacts` or `engine` and the result does not tell them.
  void result(const PhysicsStep& step, const PhysicsResult& result);

  [[nodiscard]] const NodeSpec& node() const { return session_.plan().nodes[node_]; }
  /// The samples of the handle that have come, and those that were refused.
  [[nodiscard]] const Refusals& refusals() const { return gate_.refusals(); }
  /// States of the light copy that were not sent, because readers held all arrays.
  [[nodiscard]] std::uint64_t dropped_states() const { return dropped_states_; }
  /// False where no edge ends at the node's input `coupling`.
  [[nodiscard]] bool has_coupling() const { return has_coupling_; }

 private:
  void read_inputs();
  void check_copy() const;
  void check_hand() const;
  [[nodiscard]] std::optional<EngineState> copy_state(const PhysicsStep& step, const PhysicsResult& result,
                                                      const PhysicsMessages& messages, const DeviceState& handle);
  [[nodiscard]] bool begin_step(PhysicsStep& step);
  [[nodiscard]] Time checked_time(Time valid);
  [[nodiscard]] DeviceState handle_at(Time t) const;
  void forget_samples();
  [[nodiscard]] Time period_after(Time t) const;
  void send(const PhysicsMessages& messages);

  Session& session_;
  const std::size_t node_;
  const double rate_;  // Hz
  const bool is_virtual_;
  const std::vector<Motion> moving_;  // bodies of the scene
  bool has_coupling_ = false;
  const bool reads_force_, reads_contacts_, reads_states_;  // the graph
  HandleGate gate_;
  std::optional<Time> due_;                    // when the next step may begin
  std::vector<Stamped<DeviceState>> samples_;  // of the handle, from the last result on
  std::optional<CouplingParameters> coupling_;
  std::optional<Stamped<DeviceState>> last_;  // the sample that the last step ended with
  std::optional<Time> last_result_;
  std::unique_ptr<ArrayPool<double>> copy_states_;  // null: there is no light copy
  std::uint64_t dropped_states_ = 0;
  std::vector<PhysicsMessages> pending_;  // virtual clock: visible when the period is over
};

}  // namespace tactor
