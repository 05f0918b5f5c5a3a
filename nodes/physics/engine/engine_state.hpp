// What a rollout of a foreign engine goes on from: all that the engine knows of the moving bodies.
#pragma once

#include <cstdint>

#include "framework/core/messages.hpp"
#include "framework/core/shared_array.hpp"
#include "nodes/physics/engine/coupled_engine.hpp"

namespace tactor {

/// The state of a foreign engine at a sample of the handle. Its message is stamped as the physics result that it comes
/// from. The arrays are in the engine's order and units, from which it goes on to the last bit.
struct EngineState {
  std::uint64_t identity = 0;      ///< of the engine, CoupledEngine::identity
  Trees moving = all_trees;        ///< that move while the scene goes on from here; the others stand
  Time time;                       ///< of the sample of the handle that the engine was brought to
  DeviceState device;              ///< that sample
  Vec3 p_WT_result;                ///< m, of the tool in the physics result
  Wrench wrench_result;            ///< N and N m, of the coupling on the device in that result, within its limits
  CouplingParameters coupling;     ///< that the engine was stepped with
  SharedArray<double> position;    ///< coordinates of all joints
  SharedArray<double> velocity;    ///< speeds of all degrees of freedom
  SharedArray<double> activation;  ///< states of the actuators
  SharedArray<double>
      acceleration;  ///< of all degrees of freedom in the last step, which the next solution starts from
};

template <>
const MessageType& message_type<EngineState>();

}  // namespace tactor
