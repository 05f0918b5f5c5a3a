#include "framework/session/follower.hpp"

#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor {

namespace {

constexpr Duration look_period{5'000'000};
constexpr Duration follow_period{100'000'000};
constexpr Duration felt_period{250'000'000};

}  // namespace

Follower::Follower(Session& tested, Registry& registry, const Options& options)
    : plan_(plan_follower(options.judged_by != nullptr ? *options.judged_by : tested.plan(), registry)),
      most_behind_(options.most_behind),
      tested_(tested, plan_),
      reference_(plan_, [this](Time t, const Wrench& force) {
        error_.add_true(t, force);
        if (take_reference_) take_reference_(t, force);
      }) {}

Follower::~Follower() {
  ended_ = true;
  if (thread_.joinable()) thread_.join();
}

void Follower::begin_at(const FollowedMessage& first) {
  reference_.begin_at(first.stamp.valid);
  reached_ = first.stamp.produced;
  error_.begin_again(first.stamp.valid + settling);
  begun_ = true;
}

void Follower::begin_anew() {
  const Time from = reached_;
  begin_at(*tested_.next());
  latest_.skipped += reached_ - from + settling;
  ++latest_.skips;
}

void Follower::follow() {
  tested_.read(error_);
  if (count_anew_.exchange(false)) error_.count_anew(tested_.newest());
  Instant told = MonotonicClock::now();
  while (tested_.next() != nullptr && !ended_) {
    if (!begun_) begin_at(*tested_.next());
    if (most_behind_ && tested_.newest() - reached_ > *most_behind_) {
      // A restart may take longer than one may be behind, so that the newest sample is looked for afterwards.
      reference_.restart();
      tested_.read(error_);
      tested_.skip_to_newest();
      begin_anew();
    } else if (tested_.next()->after_loss) {
      reference_.restart();
      begin_anew();
    }
    reference_.feed(*tested_.next());
    reached_ = tested_.next()->stamp.produced;
    tested_.pop();
    if (const Instant now = MonotonicClock::now(); now - told > look_period) {
      told = now;
      tested_.read(error_);
    }
  }
  error_.compare();
  tell();
}

void Follower::tell() {
  latest_.error = error_.figures();
  if (const Instant at = MonotonicClock::now(); at - felt_at_ > felt_period) {
    felt_at_ = at;
    latest_.felt = error_.felt(plan_.handle_mass);
  }
  latest_.behind = tested_.newest() - reached_;
  latest_.dropped = tested_.dropped();
  const std::scoped_lock lock(mutex_);
  figures_ = latest_;
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
