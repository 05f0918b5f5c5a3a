#include "devices/hardware/line_cycle.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tactor {

namespace {

const AxisLimits& checked(const AxisLimits& limits) {
  check(limits);
  return limits;
}

}  // namespace

LineCycle::LineCycle(std::string name, const AxisLimits& ours, const CommandTiming& timing,
                     const LineEnergyOptions& energy, const LineGuarding& guarding, const FlightWriter& flight)
    : name_(std::move(name)),
      ours_(checked(ours)),
      commands_(timing),
      own_board_(guarding.board == nullptr ? std::make_unique<LineBoard>() : nullptr),
      board_(guarding.board == nullptr ? own_board_.get() : guarding.board),
      outside_(guarding.outside),
      plausibility_(ours),
      delay_in_(energy.delay_in),
      energy_(energy),
      flight_(flight) {
  report_.limits = ours;
  if (guarding.gate) gate_.emplace(*guarding.gate);
}

bool LineCycle::newest(LinkReport& report) noexcept {
  reports_.admit();
  const MessageView view = reports_.take();
  if (view) std::memcpy(&report, view.value, sizeof report);
  return static_cast<bool>(view);
}

void LineCycle::command(Instant now, const LinkCommand& command) noexcept {
  commands_.send(now, command);
  commanded_ns_.store(now.ns, std::memory_order_release);
}

void LineCycle::pass_on(Instant commanded, const LinkCommand& command, Instant zeroed) noexcept {
  commands_.pass_on(commanded, command, zeroed);
  commanded_ns_.store(commanded.ns, std::memory_order_release);
}

void LineCycle::admit(Instant now) noexcept {
  if (outside_ != nullptr) outside_->admit(now, *this);
}

std::string LineCycle::last_failure() const {
  const std::scoped_lock lock(mutex_);
  return last_failure_;
}

bool LineCycle::opened(const LinkLimits& theirs, LinkFailure& failure) {
  AxisLimits limits = ours_;
  limits.tighten(theirs);
  for (int i = 0; i < limits.axes; ++i) {
    const auto a = static_cast<std::size_t>(i);
    if (limits.q_min[a] <= limits.q_max[a]) continue;
    failure = {LinkError::identity,
               "axis " + std::to_string(i + 1) + " of the device moves from " + std::to_string(theirs.q_min[a]) +
                   " to " + std::to_string(theirs.q_max[a]) + ", and the workspace is given as " +
                   std::to_string(ours_.q_min[a]) + " to " + std::to_string(ours_.q_max[a]),
               true};
    return false;
  }
  wants_reopen_.store(false, std::memory_order_release);
  report_.limits = limits;
  plausibility_.set(limits);
  effort_ = {};
  energy_.reopen();
  if (gate_) gate_->reopen();
  turned_ = {};
  given_ = {};
  if (flight_) flight_.ring->tell(FlightEvent::line_opened, flight_.node, MonotonicClock::now(), name_);
  commands_.cut(MonotonicClock::now());
  if (outside_ != nullptr) {
    // A link starts its device up with zero effort.
    outside_->given({});
    outside_->delivered();
  }
  publish();
  return true;
}

LinkCommand LineCycle::due(Instant now) {
  admit(now);
  LinkCommand command = commands_.due(now);
  if (commands_.has_expired()) metrics().expired.add(1);
  const bool limited = report_.limits.shorten(command);
  if (limited) metrics().limited.add(1);
  if (gate_) command.effort = gate_->give(now, command.effort, report_.limits);
  effort_ = energy_.give(Time{now.ns}, command.effort, command.weight);
  given_ = now;
  exchange_.limited = limited ? 1 : 0;
  exchange_.bounded = effort_ != command.effort ? 1 : 0;
  command.effort = effort_;
  if (gate_) gate_->gave(now, effort_);
  if (outside_ != nullptr) outside_->given(command);
  const bool holds = gate_ && gate_->hold() != report_.hold;
  if (holds || commands_.cuts() != report_.cuts || commands_.expiries() != report_.expiries) publish();
  return command;
}

void LineCycle::took(Instant began, const LinkSample& sample, std::string_view fault) {
  metrics().cycles.add(1);
  if (outside_ != nullptr) outside_->delivered();
  if (effort_ != AxisValues{}) metrics().forced_cycles.add(1);
  report_.sample = sample;
  report_.sampled = began;
  ++report_.samples;
  report_.verdict = plausibility_.judge(report_.sample, began, effort_);
  report_.finding = plausibility_.finding();
  if (report_.verdict != Plausibility::Verdict::jumped) {
    energy_.take(Time{began.ns} - delay_in_, report_.sample.q);
    if (gate_) gate_->see(began, report_.sample.q, report_.limits);
  }
  report_.energy = energy_.totals();
  metrics().jumps.set(static_cast<std::int64_t>(plausibility_.jumps()));
  metrics().stuck.set(static_cast<std::int64_t>(plausibility_.times_stuck()));
  samples_.store(report_.samples, std::memory_order_release);
  if (sample.faults != 0) {
    failed({LinkError::device_fault, std::string(fault)});
  } else {
    report_.error = LinkError::none;
    publish();
    tell_flight(LinkError::none);
  }
  board_->pace.beat();
}

LinkCommand LineCycle::turn(const LinkSample& sample, std::string_view fault) {
  const Instant now = MonotonicClock::now();
  if (turned_ != Instant{}) metrics().cycle_time.record(now - turned_);
  turned_ = now;
  called_ns_.store(now.ns, std::memory_order_release);
  took(now, sample, fault);
  return due(MonotonicClock::now());
}

void LineCycle::failed(const LinkFailure& failure) {
  called_ns_.store(MonotonicClock::now().ns, std::memory_order_release);
  metrics().by_error[static_cast<std::size_t>(failure.error)].add(1);
  const std::string text = name_ + ": " + failure.text;
  tell_flight(failure.error);
  if (flight_ && (report_.error != failure.error || !text.starts_with(report_.text.data()))) {
    // Once for cycles that fail alike: their records tell the kind.
    flight_.ring->tell(FlightEvent::line_failed, flight_.node, MonotonicClock::now(),
                       std::string(name_of(failure.error)) + ": " + text);
  }
  report_.error = failure.error;
  report_.asks_user = failure.asks_user;
  report_.text.fill('\0');
  std::memcpy(report_.text.data(), text.data(), std::min(text.size(), report_.text.size() - 1));
  {
    const std::scoped_lock lock(mutex_);
    last_failure_ = text;
  }
  publish();
  if (failure.reopen) wants_reopen_.store(true, std::memory_order_release);
}

/// The cycle under way has ended so.
void LineCycle::tell_flight(LinkError error) {
  if (!flight_ || given_ == Instant{}) return;
  const Instant begun = std::exchange(given_, Instant{});
  for (std::size_t a = 0; a < max_axes; ++a) {
    exchange_.effort[a] = static_cast<float>(effort_[a]);
    exchange_.q[a] = static_cast<float>(report_.sample.q[a]);
  }
  exchange_.took_s = static_cast<float>((MonotonicClock::now() - begun).seconds());
  exchange_.command_age_s = static_cast<float>((begun - commanded()).seconds());
  exchange_.generated_J = static_cast<float>(report_.energy.generated_J);
  exchange_.allowed_J = static_cast<float>(report_.energy.allowed_J);
  exchange_.faults = report_.sample.faults;
  exchange_.error = static_cast<std::uint8_t>(error);
  exchange_.verdict = static_cast<std::uint8_t>(report_.verdict);
  exchange_.expired = commands_.has_expired() ? 1 : 0;
  exchange_.cuts = static_cast<std::uint32_t>(commands_.cuts());
  flight_.ring->add(FlightKind::exchange, flight_.node, begun, exchange_);
}

void LineCycle::publish() {
  report_.cuts = commands_.cuts();
  report_.expiries = commands_.expiries();
  if (gate_) report_.hold = gate_->hold();
  if (outside_ != nullptr) return outside_->publish(report_);
  reports_.push({}, &report_);
}

}  // namespace tactor
