// Tells steps that do not come back from nodes that have nothing to do.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "framework/core/time.hpp"

namespace tactor {

/// What is known of the steps of each node. Looked at now and then, by one thread at a time.
class StallWatch {
 public:
  struct Node {
    Time moved;  ///< when it was last seen idle or with a new step
    bool stalled = false;
  };

  /// A step that has not come back for longer than `timeout` has stalled.
  StallWatch(std::size_t nodes, Duration timeout) : timeout_(timeout), nodes_(nodes), ended_(nodes, -1) {}

  /// Begins a round of looks. Where the watch itself was kept from looking (a stopped process, a machine that slept) no
  /// step is blamed for it.
  void begin(Time now) {
    constexpr Duration longest_between{200'000'000};
    unwatched_ = std::max(now - now_ - longest_between, Duration{});
    now_ = now;
  }
  /// Looks at a node that has ended so many steps.
  const Node& look(std::size_t node, std::int64_t ended, bool idle) {
    Node& watched = nodes_[node];
    watched.moved = idle || ended != ended_[node] ? now_ : watched.moved + unwatched_;
    watched.stalled = now_ - watched.moved > timeout_;
    ended_[node] = ended;
    return watched;
  }
  [[nodiscard]] bool stalled(std::size_t node) const { return nodes_[node].stalled; }

 private:
  Duration timeout_;
  std::vector<Node> nodes_;
  std::vector<std::int64_t> ended_;  // steps, when it was last looked at
  Time now_;
  Duration unwatched_;
};

}  // namespace tactor
