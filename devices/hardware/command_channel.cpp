#include "devices/hardware/command_channel.hpp"

#include <algorithm>
#include <cstring>

namespace tactor {

namespace {

/// More expiries than this in that time are no lateness any more.
constexpr int most_expiries = 10;
constexpr Duration counted_for{1'000'000'000};

LinkCommand share_of(const LinkCommand& command, double share) {
  LinkCommand part = command;
  for (AxisValues* values : {&part.effort, &part.weight}) {
    for (double& one : *values) one *= share;
  }
  return part;
}

}  // namespace

void CommandChannel::send(Instant now, const LinkCommand& command) noexcept {
  if (command.is_zero()) zeroed_ = now;
  pass_on(now, command, zeroed_);
}

void CommandChannel::pass_on(Instant now, const LinkCommand& command, Instant zeroed) noexcept {
  const Order order{command, zeroed};
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
    return letting_go(now, age);
  }
  expired_ = false;
  return returns_ ? coming_back(now) : newest_.command;
}

/// The part that is left of a command that has expired.
LinkCommand CommandChannel::letting_go(Instant now, Duration age) {
  const Duration late = age - timing_.expires_after;
  const bool partly = late < timing_.let_go;
  double share = partly ? 1 - late.seconds() / timing_.let_go.seconds() : 0;
  // A command that expires while it comes back goes down from where it was.
  if (returns_) share = std::min(share, share_given_);
  expired_ = returns_ = true;
  share_given_ = share;
  without_until_ = now - Duration::from_seconds(share * newest_.command.return_time.seconds());
  return share > 0 ? share_of(newest_.command, share) : LinkCommand{};
}

LinkCommand CommandChannel::coming_back(Instant now) {
  const Duration since = now - without_until_;
  const Duration whole = newest_.command.return_time;
  if (since >= whole) {
    returns_ = false;
    return newest_.command;
  }
  share_given_ = since.seconds() / whole.seconds();
  return share_of(newest_.command, share_given_);
}

void CommandChannel::cut(Instant now) {
  cut_ = true;
  cut_since_ = now;
  ++cuts_;
}

}  // namespace tactor
