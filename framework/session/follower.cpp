#include "framework/session/follower.hpp"

#include <algorithm>
#include <cstring>

#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor {

namespace {

/// Room for more of a 1 kHz device than the follower may be behind.
constexpr Queue tap_queue{QueuePolicy::drop_newest, 4096};
constexpr Duration look_period{5'000'000};
constexpr Duration follow_period{100'000'000};
constexpr Duration felt_period{250'000'000};
/// Before the first sample of a session, so that no time of it is below zero.
constexpr Duration head_start{1'000'000};

}  // namespace

Follower::Follower(Session& tested, Registry& registry, const Options& options)
    : tested_(tested),
      plan_(plan_follower(options.judged_by != nullptr ? *options.judged_by : tested.plan(), registry)),
      most_behind_(options.most_behind) {
  for (const FollowerPlan::Fed& fed : plan_.fed) taps_.push_back(tested_.tap(fed.output, tap_queue));
  judged_ = tested_.tap(plan_.judged, tap_queue);
  stop_ = tested_.tap_stop();
  next_.resize(taps_.size(), 0);
  make_session();
}

Follower::~Follower() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
}

void Follower::make_session() {
  feeds_.clear();
  session_ = std::make_unique<Session>(plan_.plan);
  for (const FollowerPlan::Fed& fed : plan_.fed) feeds_.push_back(session_->feed(fed.node));
  session_->on_message(plan_.reference, [this](const Stamp& stamp, const void* value) {
    Wrench force;
    std::memcpy(static_cast<void*>(&force), value, sizeof force);
    const Time at = stamp.valid + (base_ - Time{});
    error_.add_true(at, force);
    if (take_reference_) take_reference_(at, force);
  });
  session_->start();
}

void Follower::begin_at(const Waiting& first) {
  base_ = first.stamp.valid - head_start;
  reached_ = first.stamp.produced;
  error_.begin_again(first.stamp.valid + settling);
  begun_ = true;
}

void Follower::take_fed() {
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

void Follower::take_in() {
  take_fed();
  // While one tap was read, an earlier message than the last may have come to another: it is there after a second look.
  complete_until_ = newest_;
  if (taps_.size() > 1) {
    take_fed();
    std::stable_sort(waiting_.begin(), waiting_.end(),
                     [](const Waiting& a, const Waiting& b) { return a.stamp.produced < b.stamp.produced; });
  }
  std::vector<Stamped<Wrench>> displayed;
  while (const MessageView message = judged_->take()) {
    displayed.push_back({*message.stamp, {}});
    std::memcpy(static_cast<void*>(&displayed.back().value), message.value, sizeof(Wrench));
  }
  // Told before anything that came after it, so that it is looked for last.
  if (const MessageView stop = stop_->take()) stopped_ = stop.stamp->produced;
  for (const auto& [stamp, force] : displayed) {
    if (!stopped_ || stamp.produced < *stopped_) error_.add_displayed(stamp.valid, force);
  }
}

void Follower::go_along(const Waiting& next) {
  const Duration since = base_ - Time{};
  const Time at = next.stamp.produced - since;
  if (at > session_->now()) session_->advance(at - session_->now());
  // An edge of policy `block` that has no room loses it; the plans of references have none.
  static_cast<void>(feeds_[next.feed].send(next.value.data(), next.stamp.valid - since));
  reached_ = next.stamp.produced;
}

void Follower::begin_anew() {
  const Time from = reached_;
  begin_at(waiting_.front());
  skipped_ += reached_ - from + settling;
  ++skips_;
}

void Follower::skip() {
  // It may take longer than one may be behind, so that the newest sample is looked for afterwards.
  make_session();
  take_in();
  waiting_.erase(waiting_.begin(), waiting_.end() - 1);
  complete_until_ = std::max(complete_until_, waiting_.front().stamp.produced);
  begin_anew();
}

void Follower::follow() {
  take_in();
  if (count_anew_.exchange(false)) error_.count_anew(newest_);
  Instant told = MonotonicClock::now();
  while (!waiting_.empty() && waiting_.front().stamp.produced <= complete_until_ && !ended_) {
    if (!begun_) begin_at(waiting_.front());
    if (most_behind_ && newest_ - reached_ > *most_behind_) {
      skip();
    } else if (waiting_.front().after_loss) {
      make_session();
      begin_anew();
    }
    go_along(waiting_.front());
    waiting_.pop_front();
    if (const Instant now = MonotonicClock::now(); now - told > look_period) {
      told = now;
      take_in();
    }
  }
  error_.compare();
  tell();
}

void Follower::tell() {
  FollowerFigures now;
  now.error = error_.figures();
  if (const Instant at = MonotonicClock::now(); at - felt_at_ > felt_period) {
    felt_at_ = at;
    felt_ = error_.felt(plan_.handle_mass);
  }
  now.felt = felt_;
  now.behind = newest_ - reached_;
  now.skipped = skipped_;
  now.skips = skips_;
  for (const auto& tap : taps_) now.dropped += tap->dropped();
  now.dropped += judged_->dropped();
  const std::scoped_lock lock(mutex_);
  figures_ = std::move(now);
}

void Follower::run() {
  give_way();
  try {
    for (bool last = false; !ended_ && !last;) {
      last = finishing_;
      follow();
      if (!last) MonotonicClock::sleep_until(MonotonicClock::now() + follow_period);
    }
  } catch (const std::exception& error) {
    const std::scoped_lock lock(mutex_);
    figures_.failure = error.what();
  }
  finished_ = true;
}

void Follower::start() {
  TACTOR_DEMAND(!thread_.joinable());
  thread_ = make_thread("follower", [this] { run(); });
}

void Follower::finish(Duration patience) {
  if (!thread_.joinable()) return;
  finishing_ = true;
  const Instant until = MonotonicClock::now() + patience;
  while (!finished_ && MonotonicClock::now() < until) MonotonicClock::sleep_until(MonotonicClock::now() + look_period);
  ended_ = true;
  thread_.join();
}

FollowerFigures Follower::figures() const {
  const std::scoped_lock lock(mutex_);
  return figures_;
}

}  // namespace tactor
