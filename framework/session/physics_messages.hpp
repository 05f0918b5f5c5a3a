// What a program's physics came to, and the messages that tell it.
#pragma once

#include <bitset>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/engine_state.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/scene.hpp"

namespace tactor {

/// Refuses a result: `result: FIELD: REASON`.
class ResultError : public InputError {
 public:
  ResultError(std::string field, std::string reason)
      : InputError("result: " + field + ": " + reason), field_(std::move(field)), reason_(std::move(reason)) {}
  [[nodiscard]] const std::string& field() const { return field_; }  ///< such as `contacts[3].n_W`
  [[nodiscard]] const std::string& reason() const { return reason_; }

 private:
  std::string field_, reason_;
};

/// What a step of a program's physics came to. Nothing is sent of what is not given. Frames: W world, D handle, T tool.
struct PhysicsResult {
  std::optional<Time> time;        ///< that it holds for; empty: PhysicsStep::end
  std::optional<Pose> X_WT;        ///< m; empty: the first of `bodies`, or no tool
  Twist V_WT;                      ///< m/s, rad/s
  std::optional<Wrench> felt_D_W;  ///< N, N m, on the device; empty: the graph's coupling makes it of the tool's pose
  std::optional<Wrench> contact_T_W;  ///< N, N m, sum of the contacts on the tool about its origin; empty: not known
  /// The contacts; null: none are told. Its `bodies` and `penetrating` follow from the rest of the result.
  const ContactSet* contacts = nullptr;
  const BodyStates* bodies = nullptr;  ///< all moving bodies of the scene, the tool first; null: the tool alone
  /// The state that the program's light copy is to go on from, as many numbers as it has (PhysicsLoop::rollout). Empty:
  /// not told. Copied before `result` returns.
  std::span<const double> copy_state;
  /// The rotation and angular velocity of that moving body, the tool first, are not told; refused where it turns.
  std::bitset<BodyStates::capacity> without_rotation;
  /// `p_TC` of that contact is not told: it is the point at `distance` along `n_W` from `p_WC`.
  std::bitset<ContactSet::capacity> without_p_TC;
};

/// The messages of a result, in the order of the outputs of physics.external.
struct PhysicsMessages {
  Time valid;
  std::optional<PhysicsState> state;
  std::optional<BodyStates> bodies;
  std::optional<ContactSet> contacts;
  std::optional<Wrench> force;
  std::optional<EngineState> engine;  ///< made by PhysicsLoop, of `copy_state`
};

/// The messages of a result that holds for `valid`, where the handle was at `handle`. `moving`: how the moving bodies
/// of the scene move, the tool first. Quaternions and normals that are of unit length within 0.1 % become so exactly.
/// Without `contact_T_W`, the state says that its contact force is not known (PhysicsState::damped). Throws ResultError
/// where a number is not finite or out of range, a length is not one, a body that turns has no rotation, a contact
/// contradicts itself or counts bodies that are not there, or there are too many contacts or not as many bodies as the
/// scene has.
PhysicsMessages physics_messages(const PhysicsResult& result, Time valid, const DeviceState& handle,
                                 std::span<const Motion> moving);

}  // namespace tactor
