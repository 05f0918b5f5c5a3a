#include "nodes/physics/engine/engine_state.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<EngineState>() {
  static const MessageType type = Describe<EngineState>("EngineState", "W")
                                      .field("time", &EngineState::time)
                                      .field("device", &EngineState::device)
                                      .field("p_WT_result", "m", &EngineState::p_WT_result)
                                      .field("wrench_result", &EngineState::wrench_result)
                                      .field("coupling", &EngineState::coupling)
                                      .field("position", "1", &EngineState::position)
                                      .field("velocity", "1", &EngineState::velocity)
                                      .field("activation", "1", &EngineState::activation)
                                      .field("acceleration", "1", &EngineState::acceleration)
                                      .type();
  return type;
}

}  // namespace tactor
