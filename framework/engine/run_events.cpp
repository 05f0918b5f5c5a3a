#include "framework/engine/run_events.hpp"

#include "framework/core/describe.hpp"

namespace tactor {

template <>
const MessageType& message_type<StepEvent>() {
  static const MessageType type =
      Describe<StepEvent>("tactor.StepEvent", "",
                          "A step that has passed. Stamped valid for the time at which it began, produced when it had "
                          "passed. Under the virtual clock the difference is the modelled cost; live it is the time "
                          "until the results were visible.")
          .field("node", "1", &StepEvent::node, "The node that stepped, as an index into the plan of the run.")
          .type();
  return type;
}

template <>
const MessageType& message_type<TickEvent>() {
  static const MessageType type =
      Describe<TickEvent>("tactor.TickEvent", "",
                          "A tick of a node in the real-time lane. Stamped valid for its deadline, produced when the "
                          "engine took it out of the lane. The sequence counts the ticks of the node. A tick without "
                          "an event was missed.")
          .field("node", "1", &TickEvent::node, "The node that ticked, as an index into the plan of the run.")
          .field("inputs", "1", &TickEvent::inputs, "Entries of `seen` in use.")
          .field("tick", "1", &TickEvent::tick, "Number of the tick, from 0.")
          .choice("phase", &TickEvent::phase,
                  {{"starting", Phase::starting}, {"running", Phase::running}, {"stopping", Phase::stopping}},
                  "Phase of the run, as the tick saw it.")
          .field("sets", "1", &TickEvent::sets, "Changes of parameters that the node had been given by then.")
          .field("seen", "1", &TickEvent::seen,
                 "By edge into the node, in the order of the plan: the sequence of the newest message that the tick "
                 "saw, plus one; 0 where it saw none.")
          .type();
  return type;
}

template <>
const MessageType& message_type<StopEvent>() {
  static const MessageType type =
      Describe<StopEvent>("tactor.StopEvent", "",
                          "The stop of a run: devices ramp down from now on, and sinks get nothing more. Stamped valid "
                          "for that time.")
          .field("failed", "1", &StopEvent::failed,
                 "1: the run stops because something failed. 0: as planned or asked.")
          .type();
  return type;
}

template <>
const MessageType& message_type<SetEvent>() {
  static const MessageType type =
      Describe<SetEvent>("tactor.SetEvent", "",
                         "A parameter of a node was set. Without text, a request of the node is done. Stamped valid "
                         "for the time from which it holds.")
          .field("node", "1", &SetEvent::node, "The node, as an index into the plan of the run.")
          .field("length", "1", &SetEvent::length, "Bytes of `text` in use.")
          .field("text", "1", &SetEvent::text, "`parameter=value` in UTF-8, as in a graph file.")
          .type();
  return type;
}

}  // namespace tactor
