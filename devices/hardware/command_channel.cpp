#include "devices/hardware/command_channel.hpp"

#include <cstring>

namespace tactor {

namespace {

/// More expiries than this in that time are no lateness any more.
constexpr int most_expiries = 10;
constexpr Duration counted_for{1'000'000'000};

}  // namespace

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
    if (!cut_) cut(now);
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
      if (now - counted_since_ > counted_for) {
        counted_since_ = now;
        counted_ = 0;
      }
      if (++counted_ > most_expiries) {
        counted_ = 0;
        cut(now);
        return {};
      }
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
  const Duration whole = newest_.command.return_time;
  if (since >= whole) {
    returns_ = false;
    return newest_.command;
  }
  LinkCommand part = newest_.command;
  const double share = since.seconds() / whole.seconds();
  for (AxisValues* values : {&part.effort, &part.weight}) {
    for (double& one : *values) one *= share;
  }
  return part;
}

void CommandChannel::cut(Instant now) {
  cut_ = true;
  cut_since_ = now;
  ++cuts_;
}

}  // namespace tactor
