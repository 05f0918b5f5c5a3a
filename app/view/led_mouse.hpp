// The device.mouse that a page leads: where it was sent last, and whether a person holds it.
#pragma once

#include "app/view/hold.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// Used by one thread at a time.
class LedMouse {
 public:
  /// `mouse`: a node device.mouse of the session, which outlives it; `start`: of its handle. Before the session starts.
  LedMouse(Session& session, const NodeSpec& mouse, const Pose& start);
  /// The page in control moves the cursor.
  void input(const Pose& X_WC, bool held);
  /// The page in control has gone: nobody holds the cursor where it is.
  void page_gone();
  [[nodiscard]] Hold hold(Instant now) const { return hold_.at(now); }

 private:
  void send(bool held);

  Session::Feed cursor_;
  HoldWatch hold_;
  Pose X_WC_;  // sent last
};

}  // namespace tactor
