// device.Cursor: where a person wants the handle of a device.mouse, and whether they hold it.
#pragma once

#include "framework/core/describe.hpp"

namespace tactor {

/// One input of a page: sent at each movement, and as a heartbeat while nothing moves.
struct Cursor {
  Pose X_WC;              ///< m, where the handle is wanted
  std::int32_t held = 0;  ///< 1: the person holds the handle
};

template <>
inline const MessageType& message_type<Cursor>() {
  static const MessageType type =
      Describe<Cursor>("device.Cursor", "W").field("X_WC", "m", &Cursor::X_WC).field("held", "1", &Cursor::held).type();
  return type;
}

}  // namespace tactor
