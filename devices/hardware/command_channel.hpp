// The commands on their way from a device loop to the thread of its line, and when they are cut to zero.
#pragma once

#include <cstdint>
#include <optional>

#include "devices/hardware/link.hpp"
#include "framework/core/time.hpp"
#include "framework/node/edge_queue.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// The newest command of the loop, as the line may send it.
///
/// The command is *cut*, zero is sent whatever the loop commands, from every call of `cut` on, and from a command on
/// that is older than `age_max`, until the loop has commanded exactly zero once after that. A zero counts however short
/// it was: a slow line need not have had a cycle in it.
class CommandChannel {
 public:
  explicit CommandChannel(Duration age_max) : age_max_(age_max) {}

  /// Device loop: the command from now on. Wait-free.
  void send(Instant now, const LinkCommand& command) noexcept;

  // The line's thread.

  /// Takes what has come, and gives the command that the device is to have at `now`.
  LinkCommand due(Instant now);
  void cut();
  [[nodiscard]] std::uint64_t cuts() const { return cuts_; }  ///< so far
  /// When the newest command was given that has been taken; absent: none.
  [[nodiscard]] const std::optional<Instant>& commanded() const { return commanded_; }

 private:
  struct Order {
    LinkCommand command;
    Instant zeroed;  // when zero was commanded last
  };

  const Duration age_max_;
  EdgeQueue orders_{sizeof(Order), alignof(Order), Queue{}};
  // The loop's.
  Instant zeroed_{INT64_MIN};

  // The thread's.
  Order newest_;
  std::optional<Instant> commanded_;
  bool cut_ = true;
  Instant cut_since_;
  std::uint64_t cuts_ = 0;
};

}  // namespace tactor
