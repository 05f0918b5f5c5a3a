// A message type: what a tactile pad of 8 by 8 fields feels.
#pragma once

#include "framework/core/describe.hpp"

namespace example_nodes {

struct Pad {
  tactor::Time pressed_since;
  double force = 0;                     // N
  tactor::SharedArray<float> pressure;  // Pa
};

}  // namespace example_nodes

// Recordings, CSV, Python and the view read this description. Its sentences appear in `tactor schema --messages` and in
// Python's help.
template <>
inline const tactor::MessageType& tactor::message_type<example_nodes::Pad>() {
  using example_nodes::Pad;
  static const MessageType type =
      Describe<Pad>("example.Pad", "",
                    "The load on a pad of 8 by 8 fields. Stamped valid for the force that it spreads.")
          .field("pressed_since", &Pad::pressed_since, "Time of the run at which the present or last touch began.")
          .field("force", "N", &Pad::force, "Norm of the force on the whole pad.")
          .field("pressure", "Pa", &Pad::pressure, "Pressure of each field, row by row; it may be empty.")
          .type();
  return type;
}
