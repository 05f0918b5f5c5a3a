// Why a page holds the tool or does not, and why a run ended, as the page is told them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// The dead-man button of device.mouse.
enum class Hold : std::uint8_t {
  never,      ///< nobody has held the tool yet
  held,       ///< a person holds it
  let_go,     ///< the person let go of it
  silent,     ///< the page sent nothing for the heartbeat timeout; it has to let go before it can hold again
  page_gone,  ///< the page in control was closed, or its connection was lost
};
inline constexpr std::array<std::string_view, 5> hold_words{"never", "held", "let_go", "silent", "page_gone"};

/// Why a run ended.
enum class RunEnd : std::uint8_t {
  over,         ///< its time is over, or its owner ended it
  stopped,      ///< a page asked for it
  interrupted,  ///< Ctrl-C, or a signal
  stalled,      ///< a node did not come back
  failed,       ///< a node or a device failed
};
inline constexpr std::array<std::string_view, 5> run_end_words{"over", "stopped", "interrupted", "stalled", "failed"};

inline std::string_view name_of(Hold hold) {
  return hold_words[static_cast<std::size_t>(hold)];
}
inline std::string_view name_of(RunEnd end) {
  return run_end_words[static_cast<std::size_t>(end)];
}

/// Follows the inputs of the page in control by the rule of device.mouse.
class HoldWatch {
 public:
  /// `timeout`: heartbeat_timeout of the device.
  explicit HoldWatch(Duration timeout) : timeout_(timeout) {}

  void input(bool held, Instant now) {
    if (is_silent(now)) must_let_go_ = true;
    if (!held) must_let_go_ = false;
    if (held_ && !held) not_held_ = Hold::let_go;
    held_ = held;
    last_ = now;
  }
  /// The page in control has gone.
  void page_gone(Instant now) {
    input(false, now);
    not_held_ = Hold::page_gone;
  }
  [[nodiscard]] Hold at(Instant now) const {
    if (!held_) return not_held_;
    return must_let_go_ || is_silent(now) ? Hold::silent : Hold::held;
  }

 private:
  [[nodiscard]] bool is_silent(Instant now) const { return last_ && now - timeout_ > *last_; }

  Duration timeout_;
  std::optional<Instant> last_;
  bool held_ = false;
  bool must_let_go_ = false;
  Hold not_held_ = Hold::never;
};

}  // namespace tactor
