// device.Cursor: where a person wants the handle of a device.mouse, and whether they hold it.
#pragma once

#include "framework/core/describe.hpp"

namespace tactor {

/// One input of a page.
struct Cursor {
  Pose X_WC;  ///< m
  std::int32_t held = 0;
};

template <>
inline const MessageType& message_type<Cursor>() {
  static const MessageType type =
      Describe<Cursor>("device.Cursor", "W",
                       "One input of a page: sent at each movement, and as a heartbeat while nothing moves. Stamped "
                       "valid for the time at which it arrived.")
          .field("X_WC", "m", &Cursor::X_WC, "Pose C at which the person wants the handle, in the world.")
          .field("held", "1", &Cursor::held, "1: the person holds the handle. 0: it is let go.")
          .type();
  return type;
}

}  // namespace tactor
