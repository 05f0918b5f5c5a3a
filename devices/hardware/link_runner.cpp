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

}  // namespace

LinkRunner::LinkRunner(std::unique_ptr<Link> link, LinkRunnerSettings settings)
    : link_(std::move(link)),
      settings_(std::move(settings)),
      name_(link_->name()),
      commands_(settings_.command_age_max),
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

bool LinkRunner::newest(LinkReport& report) noexcept {
  reports_.admit();
  const MessageView view = reports_.take();
  if (view) std::memcpy(&report, view.value, sizeof report);
  return static_cast<bool>(view);
}

void LinkRunner::command(Instant now, const LinkCommand& command) noexcept {
  policy_.remember();
  commands_.send(now, command);
}

void LinkRunner::take_policy() {
  const std::vector<Refusal> refused = policy_.take(settings_.thread_name);
  if (refused.empty()) return;
  const std::scoped_lock lock(mutex_);
  for (const Refusal& refusal : refused) refused_.push_back(describe(refusal));
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

bool LinkRunner::back_off() {
  const Duration length = back_off_;
  back_off_ = std::min(Duration{2 * length.ns}, settings_.back_off_max);
  return pause(length);
}

void LinkRunner::run() {
  apply_thread_settings({}, settings_.thread_name);
  const TickSchedule schedule(settings_.rate);
  const Duration ahead = link_->sets_pace() ? Duration::from_seconds(periods_ahead / settings_.rate) : Duration{};
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
    MonotonicClock::sleep_until(origin + (schedule.deadline(tick) - Time{}) - ahead);
    cycle(MonotonicClock::now());
    if (!is_open_ && !any_good_ && !back_off()) break;
    const std::int64_t last = schedule.last_due(Time{} + (MonotonicClock::now() - origin));
    if (is_open_ && last > tick) metrics_.skipped.add(last - tick);
    tick = std::max(last, tick) + 1;
    const std::optional<Instant> commanded = commands_.commanded();
    if (commanded && MonotonicClock::now() - *commanded > settings_.idle_after) {
      shut_down();
      while (commands_.commanded() == commanded && pause(look_again)) due_command(MonotonicClock::now());
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
  any_good_ = false;
  if (++sessions_ > 1) metrics_.reconnects.add(1);
  commands_.cut();
  publish();
  return true;
}

LinkCommand LinkRunner::due_command(Instant now) {
  const LinkCommand command = commands_.due(now);
  if (commands_.cuts() != report_.cuts) publish();
  return command;
}

void LinkRunner::cycle(Instant began) {
  LinkFailure failure;
  LinkSample sample;
  const LinkCommand command = due_command(began);
  const bool good = link_->exchange(command, sample, failure);
  metrics_.cycle_time.record(MonotonicClock::now() - began);
  if (!good) {
    failed(failure);
    if (failure.reopen || ++failures_in_a_row_ >= settings_.failures_before_reopen) {
      is_open_ = false;
      link_->close();
    }
    return;
  }
  failures_in_a_row_ = 0;
  any_good_ = true;
  back_off_ = settings_.back_off;
  metrics_.cycles.add(1);
  if (!command.is_zero()) metrics_.forced_cycles.add(1);
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
  metrics_.by_error[static_cast<std::size_t>(failure.error)].add(1);
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
  report_.cuts = commands_.cuts();
  reports_.push({}, &report_);
}

void LinkRunner::shut_down() {
  if (is_open_) link_->close();
  is_open_ = false;
}

}  // namespace tactor
