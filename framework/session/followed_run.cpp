#include "framework/session/followed_run.hpp"

#include <algorithm>
#include <cstring>

namespace tactor {

namespace {

/// Room for more of a 1 kHz device than the follower may be behind.
constexpr Queue tap_queue{QueuePolicy::drop_newest, 4096};

}  // namespace

FollowedRun::FollowedRun(Session& tested, const FollowerPlan& plan) {
  for (const FollowerPlan::Fed& fed : plan.fed) taps_.push_back(tested.tap(fed.output, tap_queue));
  judged_ = tested.tap(plan.judged, tap_queue);
  stop_ = tested.tap_stop();
  next_.resize(taps_.size(), 0);
}

void FollowedRun::read_fed() {
  for (std::size_t i = 0; i < taps_.size(); ++i) {
    while (const MessageView message = taps_[i]->take()) {
      const auto* bytes = static_cast<const std::byte*>(message.value);
      const Stamp& stamp = *message.stamp;
      const bool after_loss = next_[i] != 0 && stamp.sequence != next_[i];
      next_[i] = stamp.sequence + 1;
      waiting_.push_back({stamp, i, {bytes, bytes + taps_[i]->type().size}, after_loss});
      newest_ = std::max(newest_, stamp.produced);
    }
  }
}

void FollowedRun::read(RunningError& error) {
  read_fed();
  // While one tap was read, an earlier message than the last may have come to another: it is there after a second look.
  complete_until_ = newest_;
  if (taps_.size() > 1) {
    read_fed();
    std::stable_sort(waiting_.begin(), waiting_.end(), [](const FollowedMessage& a, const FollowedMessage& b) {
      return a.stamp.produced < b.stamp.produced;
    });
  }
  std::vector<Stamped<Wrench>> displayed;
  while (const MessageView message = judged_->take()) {
    displayed.push_back({*message.stamp, {}});
    std::memcpy(static_cast<void*>(&displayed.back().value), message.value, sizeof(Wrench));
  }
  // Told before anything that came after it, so that it is looked for last.
  if (const MessageView stop = stop_->take()) stopped_ = stop.stamp->produced;
  for (const auto& [stamp, force] : displayed) {
    if (!stopped_ || stamp.produced < *stopped_) error.add_displayed(stamp.valid, force);
  }
}

const FollowedMessage* FollowedRun::next() const {
  return !waiting_.empty() && waiting_.front().stamp.produced <= complete_until_ ? &waiting_.front() : nullptr;
}

void FollowedRun::skip_to_newest() {
  waiting_.erase(waiting_.begin(), waiting_.end() - 1);
  complete_until_ = std::max(complete_until_, waiting_.front().stamp.produced);
}

std::uint64_t FollowedRun::dropped() const {
  std::uint64_t sum = judged_->dropped();
  for (const auto& tap : taps_) sum += tap->dropped();
  return sum;
}

}  // namespace tactor
