#include "framework/core/engine_state.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<EngineState>() {
  static const MessageType type =
      Describe<EngineState>("EngineState", "W",
                            "The whole state of a foreign engine at a sample of the device. Stamped as the physics "
                            "result that it comes from.")
          .field(
              "identity", &EngineState::identity,
              "Hash of the model's files, the tool and the keyframe; of a program's light copy, how many numbers its "
              "state has. A state goes with engines of the same.")
          .field("moving", "1", &EngineState::moving,
                 "Trees of the scene that move while it goes on from this state: bit k is tree k, and tree 0 has the "
                 "tool. The others stand where the state has them. All bits: all trees move.")
          .field("time", &EngineState::time, "Time of the device sample that the engine was moved on to.")
          .field("device", &EngineState::device, "Device sample at `time`.")
          .field("X_WT", &EngineState::X_WT, "Pose of the tool T at `time`.")
          .field("V_WT", &EngineState::V_WT, "Velocity of the tool at `time`.")
          .field("p_WT_result", "m", &EngineState::p_WT_result,
                 "Position of the origin of the tool T in the physics result, at the stamp of the message.")
          .field("wrench_result", &EngineState::wrench_result,
                 "Wrench of the coupling on the device in that result, within the limits of the device.")
          .field("coupling", &EngineState::coupling, "Spring and damper between handle and tool.")
          .field("position", "1", &EngineState::position,
                 "Coordinates of all joints in the order of the engine, in m, rad and parts of quaternions. Of a "
                 "program's light copy, all numbers of its state, and the arrays below are empty.")
          .field("velocity", "1", &EngineState::velocity,
                 "Speeds of all degrees of freedom in the order of the engine, in m/s and rad/s.")
          .field("activation", "1", &EngineState::activation,
                 "Inner states of the actuators in the order of the engine; empty where there are none.")
          .field("acceleration", "1", &EngineState::acceleration,
                 "Accelerations of all degrees of freedom in the last step, in m/s^2 and rad/s^2, from which the "
                 "solver of the engine starts the next one.")
          .type();
  return type;
}

}  // namespace tactor
