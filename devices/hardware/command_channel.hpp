// The commands on their way from a device loop to the thread of its line, when they are cut to zero, and when they
// expire.
#pragma once

#include <cstdint>
#include <optional>

#include "devices/hardware/link.hpp"
#include "framework/core/time.hpp"
#include "framework/node/edge_queue.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// How long a command holds.
struct CommandTiming {
  Duration age_max{50'000'000};     ///< the command is cut: the loop has stopped
  Duration expires_after{age_max};  ///< the command has expired: the loop is late
  Duration let_go{};                ///< from an expired command to zero, linearly; 0: at once
};

/// The newest command of the loop, as the line may send it.
///
/// The command is *cut*, zero is sent whatever the loop commands, from every call of `cut` on, and from a command on
/// that is older than age_max, until the loop has commanded exactly zero once after that. A zero counts however short
/// it was: a slow line need not have had a cycle in it.
///
/// A command that is older than expires_after has *expired*: it goes to zero within let_go, and stays there until there
/// is a newer one, which then comes in over its return_time, from the share that was given last. Where that happens
/// again and again, ten times within a second, the command is cut, so that no force goes on and off for long.
class CommandChannel {
 public:
  explicit CommandChannel(const CommandTiming& timing) : timing_(timing) {}

  /// Device loop: the command from now on. Wait-free.
  void send(Instant now, const LinkCommand& command) noexcept;
  /// The same of a command from another process, where zero was commanded last at `zeroed`.
  void pass_on(Instant now, const LinkCommand& command, Instant zeroed) noexcept;

  // The line's thread.

  /// Takes what has come, and gives the command that the device is to have at `now`.
  LinkCommand due(Instant now);
  void cut(Instant now);
  [[nodiscard]] std::uint64_t cuts() const { return cuts_; }          ///< so far
  [[nodiscard]] std::uint64_t expiries() const { return expiries_; }  ///< so far
  /// True where the command given last was none, or less, for that reason.
  [[nodiscard]] bool has_expired() const { return expired_; }

 private:
  struct Order {
    LinkCommand command;
    Instant zeroed;  // when zero was commanded last
  };

  [[nodiscard]] LinkCommand coming_back(Instant now);
  [[nodiscard]] LinkCommand letting_go(Instant now, Duration age);

  const CommandTiming timing_;
  EdgeQueue orders_{sizeof(Order), alignof(Order), Queue{}};
  // The loop's.
  Instant zeroed_{INT64_MIN};

  // The thread's.
  Order newest_;
  std::optional<Instant> commanded_;
  bool cut_ = true;
  Instant cut_since_;
  std::uint64_t cuts_ = 0;
  bool expired_ = false;
  bool returns_ = false;    // after it expired
  double share_given_ = 1;  // of it then
  Instant without_until_;   // when zero was given for it last; where a part was, when zero would have been
  std::uint64_t expiries_ = 0;
  Instant counted_since_;  // expiries that may be too many
  int counted_ = 0;
};

}  // namespace tactor
