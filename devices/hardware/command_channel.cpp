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
  const Duration age = now - *commanded_;
  if (age > timing_.age_max) {
    if (!cut_) cut();
    expired_ = returns_ = false;
    return {};
  }
  if (cut_ && newest_.zeroed > cut_since_) cut_ = false;
  if (cut_ || newest_.command.is_zero()) {
    expired_ = returns_ = false;
    return {};
  }
  if (age > timing_.expires_after) {
    if (!expired_) {
      ++expiries_;
      expired_at_ = now;
    }
    expired_ = returns_ = true;
    without_until_ = now;
    return {};
  }
  expired_ = false;
  return returns_ ? coming_back(now) : newest_.command;
}

LinkCommand CommandChannel::coming_back(Instant now) {
  const Duration since = now - without_until_;
  if (since >= timing_.return_time) {
    returns_ = false;
    return newest_.command;
  }
  LinkCommand part = newest_.command;
  for (double& effort : part.effort) effort *= since.seconds() / timing_.return_time.seconds();
  return part;
}

void CommandChannel::cut() {
  cut_ = true;
  cut_since_ = MonotonicClock::now();
  ++cuts_;
}

}  // namespace tactor
