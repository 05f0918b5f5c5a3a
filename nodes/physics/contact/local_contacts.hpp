// The contacts around the moving bodies for some time ahead: what a local rollout pushes against.
#pragma once

#include <array>
#include <cstdint>

#include "framework/core/describe.hpp"
#include "framework/core/messages.hpp"

namespace tactor {

/// The contacts around the moving bodies at several poses, the anchors.
struct LocalContacts {
  static constexpr int capacity = 48;
  static constexpr int max_anchors = 3;
  std::int32_t anchors = 0;
  std::int32_t bodies = 0;
  std::int32_t count = 0;
  std::array<std::array<Pose, BodyStates::capacity>, max_anchors> X_WB;  ///< m
  std::array<std::array<Contact, max_anchors>, capacity> contact;
  std::array<ContactPair, capacity> pair;
};

template <>
inline const MessageType& message_type<LocalContacts>() {
  static const MessageType type =
      Describe<LocalContacts>("LocalContacts", "W",
                              "The contacts around the moving bodies for some time ahead. Each is given at several "
                              "poses, the anchors, so that a surface that bends or ends is known on the likely way of "
                              "the bodies. Stamped valid for the time at which the query began.")
          .field("anchors", "1", &LocalContacts::anchors,
                 "Anchors in use. The first has the bodies where they are at the stamp, the others later and later.")
          .field("bodies", "1", &LocalContacts::bodies, "Moving bodies in use, the tool first.")
          .field("count", "1", &LocalContacts::count, "Entries of `contact` and `pair` in use.")
          .field("X_WB", &LocalContacts::X_WB, "Pose of each moving body B in the world, by anchor and body.")
          .field("contact", &LocalContacts::contact,
                 "Contacts by contact and anchor: `contact[i][j]` is contact i, linearised at anchor j.")
          .field("pair", &LocalContacts::pair)
          .type();
  return type;
}

}  // namespace tactor
