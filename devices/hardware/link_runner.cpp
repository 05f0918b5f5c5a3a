#include "devices/hardware/link_runner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "framework/realtime/thread_policy.hpp"
#include "framework/realtime/tick_schedule.hpp"

namespace tactor {

namespace {

constexpr Time always{INT64_MAX};
constexpr Duration look_again{20'000'000};  // for a command, while idle

}  // namespace

LinkRunner::LinkRunner(std::unique_ptr<Link> link, LinkRunnerSettings settings)
    : link_(std::move(link)),
      settings_(std::move(settings)),
      name_(link_->name()),
      cycle_time_(std::make_unique<LatencyHistogram>()) {
  TACTOR_DEMAND(settings_.rate > 0 && settings_.rate <= TickSchedule::max_rate);
}

LinkRunner::~LinkRunner() {
  stop();
}

void LinkRunner::start() {
  TACTOR_DEMAND(!thread_.joinable());
  thread_ = std::thread([this] { run(); });
}

void LinkRunner::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stop_.store(true, std::memory_order_release);
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool LinkRunner::newest(LinkReport& report) noexcept {
  Stamp stamp;
  return reports_.take(always, stamp, &report);
}

void LinkRunner::command(Instant now, const LinkCommand& command) noexcept {
  commands_.write({Time{now.ns}, Time{now.ns}, ++commands_sent_}, &command);
}

std::string LinkRunner::last_failure() const {
  const std::scoped_lock lock(mutex_);
  return last_failure_;
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

void LinkRunner::run() {
  const ThreadGrant grant = apply_thread_settings(settings_.thread, settings_.thread_name);
  {
    const std::scoped_lock lock(mutex_);
    for (const Refusal& refusal : grant.refused) refused_.push_back(describe(refusal));
  }
  const TickSchedule schedule(settings_.rate);
  Duration back_off = settings_.back_off;
  Instant origin;
  std::int64_t tick = 0;
  while (!stopping()) {
    if (!is_open_) {
      if (!open()) {
        if (!pause(back_off)) break;
        back_off = std::min(Duration{2 * back_off.ns}, settings_.back_off_max);
        continue;
      }
      back_off = settings_.back_off;
      origin = MonotonicClock::now();
      tick = 0;
    }
    MonotonicClock::sleep_until(origin + (schedule.deadline(tick) - Time{}));
    cycle(MonotonicClock::now());
    const std::int64_t last = schedule.last_due(Time{} + (MonotonicClock::now() - origin));
    if (last > tick) skipped_.add(last - tick);
    tick = std::max(last, tick) + 1;
    if (any_command_ && MonotonicClock::now() - commanded_ > settings_.idle_after) {
      shut_down();
      const Instant seen = commanded_;
      while (commanded_ == seen && pause(look_again)) due_command(MonotonicClock::now());
    }
  }
  shut_down();
}

bool LinkRunner::open() {
  LinkFailure failure;
  if (!link_->open(failure)) {
    failed(failure);
    return false;
  }
  is_open_ = true;
  failures_in_a_row_ = 0;
  if (++sessions_ > 1) reconnects_.add(1);
  cut();
  return true;
}

void LinkRunner::cut() {
  cut_ = true;
  cut_since_ = MonotonicClock::now();
  ++report_.cuts;
  publish();
}

LinkCommand LinkRunner::due_command(Instant now) {
  Stamp stamp;
  LinkCommand command;
  if (commands_.take(always, stamp, &command)) {
    newest_command_ = command;
    commanded_ = {stamp.produced.ns};
    any_command_ = true;
  }
  if (!any_command_) return {};
  if (now - commanded_ > settings_.command_age_max) {
    if (!cut_) cut();
    return {};
  }
  if (cut_ && commanded_ > cut_since_ && newest_command_.is_zero()) cut_ = false;
  return cut_ ? LinkCommand{} : newest_command_;
}

void LinkRunner::cycle(Instant began) {
  LinkFailure failure;
  LinkSample sample;
  const LinkCommand command = due_command(began);
  const bool good = link_->exchange(command, sample, failure);
  cycle_time_->record(MonotonicClock::now() - began);
  if (!good) {
    failed(failure);
    if (failure.reopen || ++failures_in_a_row_ >= settings_.failures_before_reopen) {
      is_open_ = false;
      link_->close();
    }
    return;
  }
  failures_in_a_row_ = 0;
  cycles_.add(1);
  report_.sample = sample;
  report_.sampled = began;
  ++report_.samples;
  if (sample.faults != 0) {
    failed({LinkError::device_fault, failure.text});
    return;
  }
  report_.error = LinkError::none;
  publish();
}

void LinkRunner::failed(const LinkFailure& failure) {
  errors_[static_cast<std::size_t>(failure.error)].add(1);
  const std::string text = name_ + ": " + failure.text;
  report_.error = failure.error;
  report_.text.fill('\0');
  std::memcpy(report_.text.data(), text.data(), std::min(text.size(), report_.text.size() - 1));
  {
    const std::scoped_lock lock(mutex_);
    last_failure_ = text;
  }
  publish();
}

void LinkRunner::publish() {
  const Time now{MonotonicClock::now().ns};
  reports_.write({now, now, ++reports_sent_}, &report_);
}

void LinkRunner::shut_down() {
  if (is_open_) link_->close();
  is_open_ = false;
}

}  // namespace tactor
