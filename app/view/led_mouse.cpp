#include "app/view/led_mouse.hpp"

#include "devices/mouse/cursor.hpp"

namespace tactor {

LedMouse::LedMouse(Session& session, const NodeSpec& mouse, const Pose& start)
    : cursor_(session.feed(mouse.name + ".cursor")),
      hold_(Duration::from_seconds(std::get<double>(mouse.params[mouse.info->param("heartbeat_timeout").value()]))),
      X_WC_(start) {}

void LedMouse::input(const Pose& X_WC, bool held) {
  hold_.input(held, MonotonicClock::now());
  X_WC_ = X_WC;
  send(held);
}

void LedMouse::page_gone() {
  hold_.page_gone(MonotonicClock::now());
  send(false);
}

void LedMouse::send(bool held) {
  Cursor cursor;
  cursor.X_WC = X_WC_;
  cursor.held = held ? 1 : 0;
  // The edge is `latest`, which always has room.
  static_cast<void>(cursor_.send(cursor));
}

}  // namespace tactor
