#include "devices/hardware/command_channel.hpp"

#include <cstring>

namespace tactor {

void CommandChannel::send(Instant now, const LinkCommand& command) noexcept {
  if (command.is_zero()) zeroed_ = now;
  const Order order{command, zeroed_};
  orders_.push({Time{now.ns}, Time{now.ns}}, &order);
}

LinkCommand CommandChannel::due(Instant now) {
  orders_.admit();
  if (const MessageView view = orders_.take()) {
    std::memcpy(&newest_, view.value, sizeof newest_);
    commanded_ = Instant{view.stamp->produced.ns};
  }
  if (!commanded_) return {};
  if (now - *commanded_ > age_max_) {
    if (!cut_) cut();
    return {};
  }
  if (cut_ && newest_.zeroed > cut_since_) cut_ = false;
  return cut_ ? LinkCommand{} : newest_.command;
}

void CommandChannel::cut() {
  cut_ = true;
  cut_since_ = MonotonicClock::now();
  ++cuts_;
}

}  // namespace tactor
