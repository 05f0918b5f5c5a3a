// The contacts around the moving bodies for some time ahead: what a local rollout pushes against.
#pragma once

#include <array>
#include <cstdint>

#include "framework/core/describe.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// The contacts around the moving bodies for some time ahead: each as a query at several poses gives it, the anchors,
/// so that a surface that bends or ends is known on the way that the bodies are likely to take.
struct LocalContacts {
  static constexpr int capacity = 48;
  static constexpr int max_anchors = 3;
  std::int32_t anchors = 0;                                              ///< poses looked at, in the order of time
  std::int32_t bodies = 0;                                               ///< moving bodies
  std::int32_t count = 0;                                                ///< contacts
  std::array<std::array<Pose, BodyStates::capacity>, max_anchors> X_WB;  ///< m, of the moving bodies, by anchor
  std::array<std::array<Contact, max_anchors>, capacity> contact;        ///< by contact and anchor
  std::array<ContactPair, capacity> pair;
};

template <>
inline const MessageType& message_type<LocalContacts>() {
  static const MessageType type = Describe<LocalContacts>("LocalContacts", "W")
                                      .field("anchors", "1", &LocalContacts::anchors)
                                      .field("bodies", "1", &LocalContacts::bodies)
                                      .field("count", "1", &LocalContacts::count)
                                      .field("X_WB", &LocalContacts::X_WB)
                                      .field("contact", &LocalContacts::contact)
                                      .field("pair", &LocalContacts::pair)
                                      .type();
  return type;
}

}  // namespace tactor
