#include "framework/engine/run_events.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<StepEvent>() {
  static const MessageType type = Describe<StepEvent>("tactor.StepEvent").field("node", "1", &StepEvent::node).type();
  return type;
}

template <>
const MessageType& message_type<TickEvent>() {
  static const MessageType type =
      Describe<TickEvent>("tactor.TickEvent")
          .field("node", "1", &TickEvent::node)
          .field("inputs", "1", &TickEvent::inputs)
          .field("tick", "1", &TickEvent::tick)
          .choice("phase", &TickEvent::phase,
                  {{"starting", Phase::starting}, {"running", Phase::running}, {"stopping", Phase::stopping}})
          .field("sets", "1", &TickEvent::sets)
          .field("seen", "1", &TickEvent::seen)
          .type();
  return type;
}

template <>
const MessageType& message_type<StopEvent>() {
  static const MessageType type =
      Describe<StopEvent>("tactor.StopEvent").field("failed", "1", &StopEvent::failed).type();
  return type;
}

template <>
const MessageType& message_type<SetEvent>() {
  static const MessageType type = Describe<SetEvent>("tactor.SetEvent")
                                      .field("node", "1", &SetEvent::node)
                                      .field("length", "1", &SetEvent::length)
                                      .field("text", "1", &SetEvent::text)
                                      .type();
  return type;
}

}  // namespace tactor
