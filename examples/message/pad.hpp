// A message type: what a tactile pad of 8 by 8 fields feels.
#pragma once

#include "framework/core/describe.hpp"

namespace example_nodes {

struct Pad {
  tactor::Time pressed_since;           // of the touch that goes on
  double force = 0;                     // N, of all fields
  tactor::SharedArray<float> pressure;  // Pa, a value a field, row by row; it may be empty
};

}  // namespace example_nodes

// Recordings, CSV, Python and the view read this description.
template <>
inline const tactor::MessageType& tactor::message_type<example_nodes::Pad>() {
  static const MessageType type = Describe<example_nodes::Pad>("example.Pad")
                                      .field("pressed_since", &example_nodes::Pad::pressed_since)
                                      .field("force", "N", &example_nodes::Pad::force)
                                      .field("pressure", "Pa", &example_nodes::Pad::pressure)
                                      .type();
  return type;
}
