// The text `status`, which tells the pages of a running session how it runs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/view/hold.hpp"
#include "app/view/stream_taps.hpp"

namespace tactor {

/// Writes the text four times a second, with rates over the time since the last one.
class StatusText {
 public:
  /// All outlive it. `follower`: null where nothing follows; `blind`: it tells nothing of nodes and edges.
  StatusText(Session& session, const Follower* follower, const StreamTaps& taps, bool blind);
  /// Whether it is time for another text.
  [[nodiscard]] bool is_due(Instant now) const;
  /// The text of `now`; empty the first time, which rates are counted from. `hold`: of the mouse, where a page leads
  /// one.
  [[nodiscard]] std::string next(Instant now, std::optional<Hold> hold);

 private:
  Session& session_;
  const Follower* follower_;
  const StreamTaps& taps_;
  const bool blind_;
  Instant told_;
  Time told_at_;
  std::vector<std::uint64_t> steps_, delivered_;  // by node, by edge
};

}  // namespace tactor
