// What a rollout of a foreign engine goes on from: all that the engine knows of the moving bodies.
#pragma once

#include <cstddef>
#include <cstdint>

#include "framework/core/messages.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor {

/// Trees of a scene as a set: bit k is tree k. A tree is a child of the world with all that hangs on it. Trees that the
/// model joins otherwise are one. Tree 0 has the tool, and with it what always moves.
using Trees = std::uint64_t;
inline constexpr int most_trees = 64;
inline constexpr Trees all_trees = ~Trees{0};

/// The state of a foreign engine at a sample of the handle. Its message is stamped as the physics result that it comes
/// from. The arrays are in the engine's order and units, from which it goes on to the last bit.
struct EngineState {
  std::uint64_t identity = 0;      ///< of the engine, SteppedEngine::identity
  Trees moving = all_trees;        ///< that move while the scene goes on from here; the others stand
  Time time;                       ///< of the sample of the handle that the engine was brought to
  DeviceState device;              ///< that sample
  Pose X_WT;                       ///< m, of the tool T then
  Twist V_WT;                      ///< m/s, rad/s, of the tool then
  Vec3 p_WT_result;                ///< m, of the tool in the physics result
  Wrench wrench_result;            ///< N and N m, of the coupling on the device in that result, within its limits
  CouplingParameters coupling;     ///< that the engine was stepped with
  SharedArray<double> position;    ///< coordinates of all joints, or the numbers of a program's light copy
  SharedArray<double> velocity;    ///< speeds of all degrees of freedom
  SharedArray<double> activation;  ///< states of the actuators
  SharedArray<double>
      acceleration;  ///< of all degrees of freedom in the last step, which the next solution starts from
};

template <>
const MessageType& message_type<EngineState>();

/// Messages that edges and their readers hold at the same time.
inline constexpr std::size_t most_engine_states = 32;

}  // namespace tactor
