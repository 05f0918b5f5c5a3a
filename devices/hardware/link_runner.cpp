#include "devices/hardware/link_runner.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <optional>

#include "framework/realtime/make_thread.hpp"
#include "framework/realtime/thread_policy.hpp"
#include "framework/realtime/tick_schedule.hpp"

namespace tactor {

namespace {

constexpr double periods_ahead = 1.5;       // one, and half of one because what a device sends comes unevenly
constexpr Duration look_again{20'000'000};  // for a command, while idle
// Without a call from a thread of the device's library, after which its line is opened anew: periods, and at least.
constexpr double silent_periods = 5;
constexpr Duration look_for_silence{10'000'000};
constexpr Duration silent_at_least{100'000'000};

}  // namespace

LinkRunner::LinkRunner(std::unique_ptr<Link> link, const AxisLimits& limits, LinkRunnerSettings settings)
    : link_(std::move(link)),
      settings_(std::move(settings)),
      name_(link_->name()),
      cycle_(name_, limits, settings_.commands, settings_.energy, settings_.guarding, settings_.flight),
      back_off_(settings_.back_off) {
  TACTOR_DEMAND(settings_.rate > 0 && settings_.rate <= TickSchedule::max_rate);
}

LinkRunner::~LinkRunner() {
  stop();
}

void LinkRunner::start() {
  TACTOR_DEMAND(!thread_.joinable());
  thread_ = make_thread(settings_.thread_name, [this] { run(); });
}

void LinkRunner::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stop_.store(true, std::memory_order_release);
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void LinkRunner::command(Instant now, const LinkCommand& command) noexcept {
  policy_.remember();
  cycle_.command(now, command);
}

void LinkRunner::take_first_policy() {
  if (!settings_.begin) {
    apply_thread_settings({}, settings_.thread_name);
    return;
  }
  std::vector<std::string> refused = settings_.begin();
  const std::scoped_lock lock(mutex_);
  refused_ = std::move(refused);
}

void LinkRunner::take_policy() {
  const std::vector<Refusal> refused = policy_.take(settings_.thread_name);
  if (refused.empty()) return;
  const std::scoped_lock lock(mutex_);
  for (const Refusal& refusal : refused) refused_.push_back(describe(refusal));
}

std::vector<std::string> LinkRunner::refused() const {
  const std::scoped_lock lock(mutex_);
  return refused_;
}

bool LinkRunner::pause(Duration length) {
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, std::chrono::nanoseconds(length.ns), [this] { return stopping(); });
  return !stopping();
}

bool LinkRunner::back_off() {
  const Duration length = back_off_;
  back_off_ = std::min(Duration{2 * length.ns}, settings_.back_off_max);
  return pause(length);
}

bool LinkRunner::has_idled() const {
  const Instant commanded = cycle_.commanded();
  return commanded != Instant{} && MonotonicClock::now() - commanded > settings_.idle_after;
}

/// Shuts the device down until there is a command.
void LinkRunner::wait_idle() {
  shut_down();
  for (const Instant commanded = cycle_.commanded(); cycle_.commanded() == commanded;) {
    if (!pause(look_again)) return;
    cycle_.admit(MonotonicClock::now());
  }
}

void LinkRunner::run() {
  take_first_policy();
  const TickSchedule schedule(settings_.rate);
  const LinkPace pace = link_->pace();
  const Duration ahead = pace == LinkPace::device ? Duration::from_seconds(periods_ahead / settings_.rate) : Duration{};
  Instant origin;
  std::int64_t tick = 0;
  while (!stopping()) {
    take_policy();
    if (!is_open_) {
      if (!open()) {
        if (!back_off()) break;
        continue;
      }
      origin = MonotonicClock::now();
      tick = 0;
    }
    if (pace == LinkPace::callback) {
      watch();
    } else {
      MonotonicClock::sleep_until(origin + (schedule.deadline(tick) - Time{}) - ahead);
      exchange(MonotonicClock::now());
      const std::int64_t last = schedule.last_due(Time{} + (MonotonicClock::now() - origin));
      if (is_open_ && last > tick) cycle_.metrics().skipped.add(last - tick);
      tick = std::max(last, tick) + 1;
    }
    if (!is_open_ && !any_good_ && !back_off()) break;
    if (has_idled()) wait_idle();
  }
  shut_down();
}

bool LinkRunner::open() {
  LinkFailure failure;
  if (!link_->open(failure)) {
    cycle_.failed(failure);
    return false;
  }
  is_open_ = true;
  if (!cycle_.opened(link_->limits(), failure)) {
    shut_down();
    cycle_.failed(failure);
    return false;
  }
  failures_in_a_row_ = 0;
  any_good_ = false;
  if (++sessions_ > 1) cycle_.metrics().reconnects.add(1);
  sampled_ = MonotonicClock::now();
  watched_samples_ = cycle_.samples();
  if (link_->pace() == LinkPace::callback) link_->start(cycle_);
  return true;
}

void LinkRunner::exchange(Instant began) {
  LinkFailure failure;
  LinkSample sample;
  const bool good = link_->exchange(cycle_.due(began), sample, failure);
  cycle_.metrics().cycle_time.record(MonotonicClock::now() - began);
  if (!good) {
    cycle_.failed(failure);
    if (failure.reopen || ++failures_in_a_row_ >= settings_.failures_before_reopen) shut_down();
    return;
  }
  failures_in_a_row_ = 0;
  any_good_ = true;
  back_off_ = settings_.back_off;
  cycle_.took(began, sample, failure.text);
}

/// Looks whether samples keep coming, and whether the library's thread says that the line is of no use.
void LinkRunner::watch() {
  const Duration silence = std::max(silent_at_least, Duration::from_seconds(silent_periods / settings_.rate));
  const std::uint64_t samples = cycle_.samples();
  const Instant now = MonotonicClock::now();
  if (samples != watched_samples_) {
    watched_samples_ = samples;
    sampled_ = now;
    any_good_ = true;
    back_off_ = settings_.back_off;
  }
  const bool silent = now - sampled_ > silence;
  if (silent || cycle_.wants_reopen()) {
    const bool called = cycle_.called() > sampled_;  // and told why there was no sample
    shut_down();                                     // from here on nothing calls back
    if (silent && !called) {
      cycle_.failed({LinkError::timeout,
                     "no call of the device's library within " + std::to_string(silence.ns / 1'000'000) + " ms", true});
    }
    return;
  }
  take_policy();
  static_cast<void>(pause(look_for_silence));
}

void LinkRunner::shut_down() {
  if (is_open_) link_->close();
  is_open_ = false;
}

}  // namespace tactor
