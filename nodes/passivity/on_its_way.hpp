// What a node has sent to a device that does not show yet that it commands it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "framework/core/time.hpp"

namespace tactor {

/// The most ticks from the newest sample of a device to a command that something can be said of.
inline constexpr int most_ahead = 16;

/// Ticks for which a device keeps a command that is not renewed.
inline constexpr int held_ticks = 2;

/// Ticks from the newest sample, of the time `shown`, to the first tick after now: from 1 to `most_ahead`.
inline int ticks_ahead(Time shown, Time now, Duration tick) {
  const std::int64_t since = std::max<std::int64_t>(0, (now - shown).ns);
  return static_cast<int>(std::min<std::int64_t>(since / tick.ns + 1, most_ahead));
}

/// The values sent last, each with the tick of the device from which on it is commanded.
template <class Value>
class OnItsWay {
 public:
  /// A second one for the same tick takes the place of the first.
  void send(Time from, const Value& value) {
    if (sent_[newest_].from != from) newest_ = (newest_ + 1) % sent_.size();
    sent_[newest_] = {from, value};
  }
  /// What the device commands at a tick; null where nothing was sent for it or before.
  [[nodiscard]] const Value* at(Time tick) const {
    for (std::size_t back = 0; back < sent_.size(); ++back) {
      const Sent& sent = sent_[(newest_ + sent_.size() - back) % sent_.size()];
      if (sent.from <= tick) return &sent.value;
    }
    return nullptr;
  }

 private:
  struct Sent {
    Time from{INT64_MAX};
    Value value;
  };
  std::array<Sent, most_ahead> sent_;  // a ring
  std::size_t newest_ = 0;
};

}  // namespace tactor
