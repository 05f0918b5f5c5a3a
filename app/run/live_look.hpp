// What the terminal shows of a live run: its state, and what the safety gates of its devices say.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/session/follower.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// A live run at one moment.
struct LiveLook {
  EngineStatus status;
  std::vector<std::optional<SafetyState>> safety;  ///< by device: what its gate said last; none where it has none
  std::uint64_t record_dropped = 0;                ///< messages that the recording could not take in time
  std::optional<FollowerFigures> follower;         ///< of the reference that follows it; none where none does
};

/// Looks at a session whose clock is real, and at what follows it. Made before the start.
class LiveWatch {
 public:
  /// `follower`: null where nothing follows.
  LiveWatch(Session& session, const Follower* follower);
  [[nodiscard]] LiveLook look();

 private:
  /// The safety gate of a node.
  struct Gate {
    std::size_t node = 0;
    std::unique_ptr<Session::OutputTap> tap;
    std::optional<SafetyState> last;
  };
  Session& session_;
  const Follower* follower_;
  std::vector<Gate> gates_;
};

}  // namespace tactor
