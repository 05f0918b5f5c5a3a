#include "framework/session/reference_session.hpp"

#include <cstring>
#include <utility>

namespace tactor {

namespace {

/// Before the first sample of a session, so that no time of it is below zero.
constexpr Duration head_start{1'000'000};

}  // namespace

ReferenceSession::ReferenceSession(const FollowerPlan& plan, std::function<void(Time, const Wrench&)> take)
    : plan_(plan), take_(std::move(take)) {
  restart();
}

void ReferenceSession::restart() {
  feeds_.clear();
  session_ = std::make_unique<Session>(plan_.plan);
  for (const FollowerPlan::Fed& fed : plan_.fed) feeds_.push_back(session_->feed(fed.node));
  session_->on_message(plan_.reference, [this](const Stamp& stamp, const void* value) {
    Wrench force;
    std::memcpy(static_cast<void*>(&force), value, sizeof force);
    take_(stamp.valid + (base_ - Time{}), force);
  });
  session_->start();
}

void ReferenceSession::begin_at(Time first) {
  base_ = first - head_start;
}

void ReferenceSession::feed(const FollowedMessage& message) {
  const Duration since = base_ - Time{};
  const Time at = message.stamp.produced - since;
  if (at > session_->now()) session_->advance(at - session_->now());
  // An edge of policy `block` that has no room loses it; the plans of references have none.
  static_cast<void>(feeds_[message.feed].send(message.value.data(), message.stamp.valid - since));
}

}  // namespace tactor
