#include "devices/usb/usb_link.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr Duration longest_goodbye{100'000'000};
constexpr double still_counts = 3;
constexpr double pause_frames = 0.25;  // between two cycles, in which reports may have come
constexpr int most_unanswered = 2;     // one is answered while the next is on its way
constexpr double slow_frames = 1.5;    // a cycle that takes more of them is slow
constexpr int most_slow_cycles = 100;  // in a row: a report was lost, or the device is slow
constexpr double quiet_frames = 2;     // without a report: everything is answered
constexpr int most_late_reports = 16;

std::string name_of(const UsbProfile& profile) {
  char numbers[32];
  std::snprintf(numbers, sizeof numbers, " (USB %04x:%04x)", profile.vendor, profile.product);
  return profile.name + numbers;
}

std::string uncalibrated(const UsbProfile& profile) {
  return "its counters have no zero since it was plugged in or switched on: run `tactor device calibrate GRAPH` and "
         "put "
         "the handle into its pose (" +
         profile.calibration + ")";
}

}  // namespace

UsbLink::UsbLink(UsbProfile profile, UsbChoice choice, CalibrationStore store)
    : profile_(std::move(profile)),
      selector_(selector_of(profile_.vendor, profile_.product, choice)),
      store_(std::move(store)),
      name_(name_of(profile_)),
      zero_(profile_.input.axes.size(), 0.0),
      newest_(profile_.input.size),
      command_(profile_.output.size) {}

UsbLink::~UsbLink() = default;

void UsbLink::received(std::span<const std::uint8_t> bytes) {
  unanswered_ = std::max(0, unanswered_ - 1);
  if (bytes.size() != newest_.size()) {
    any_wrong_ = true;
    wrong_size_ = bytes.size();
    return;
  }
  if (unwanted_ > 0) {
    --unwanted_;
    return;
  }
  std::copy(bytes.begin(), bytes.end(), newest_.begin());
  fresh_ = true;
}

void UsbLink::send(const LinkCommand& command) {
  write_efforts(profile_.output, command.effort, command_);
  if (port_->send(command_)) ++unanswered_;
}

/// Lets transfers end; false, with why, where one has failed.
bool UsbLink::wait(Duration most, LinkFailure& failure) {
  const UsbResult result = port_->wait(most);
  if (result == UsbResult::ok) return true;
  failure = failure_of(result);
  // A device that has gone has lost its zero with its power.
  if (result == UsbResult::disconnected && !profile_.calibration.empty()) store_.forget(port_->identity());
  return false;
}

/// `again`, where not null, is sent a second time as soon as there is room, where the device has run out of commands.
bool UsbLink::wait_for_report(Duration most, LinkFailure& failure, const LinkCommand* again) {
  const Instant end = MonotonicClock::now() + most;
  for (Duration left = most; left.ns >= 0; left = end - MonotonicClock::now()) {
    if (any_wrong_) {
      failure = {LinkError::protocol,
                 "a report of " + std::to_string(wrong_size_) + " bytes, expected " + std::to_string(newest_.size())};
      return false;
    }
    if (fresh_) return true;
    if (again != nullptr && unanswered_ < most_unanswered && !port_->sending()) send(*again);
    if (!wait(left, failure)) return false;
  }
  char text[64];
  std::snprintf(text, sizeof text, "no report within %.3g ms", most.milliseconds());
  failure = {LinkError::timeout, text};
  return false;
}

/// Sends zero and waits for a report that comes after that.
bool UsbLink::ask_for_report(Duration most, LinkFailure& failure) {
  fresh_ = any_wrong_ = false;
  send({});
  return wait_for_report(most, failure);
}

/// Lets reports that are still to come pass by, so that it is known that no command is unanswered.
bool UsbLink::drain(LinkFailure& failure) {
  const Duration quiet = Duration::from_seconds(quiet_frames / profile_.rate);
  for (int i = 0; i < most_late_reports; ++i) {
    fresh_ = false;
    const Instant end = MonotonicClock::now() + quiet;
    for (Duration left = quiet; !fresh_ && left.ns > 0; left = end - MonotonicClock::now()) {
      if (!wait(left, failure)) return false;
    }
    if (!fresh_) break;
  }
  unanswered_ = 0;
  out_of_step_ = false;
  return true;
}

bool UsbLink::open_port(LinkFailure& failure) {
  std::string why;
  fresh_ = any_wrong_ = out_of_step_ = false;
  unanswered_ = unwanted_ = slow_ = 0;
  port_ = bus_.open(selector_, why);
  if (port_ == nullptr) {
    failure = {LinkError::disconnected, why, true};
    return false;
  }
  if (!profile_.product_text.empty() && port_->info().name != profile_.product_text) {
    failure = {LinkError::identity,
               "the device calls itself \"" + port_->info().name + "\", not \"" + profile_.product_text + "\"", true};
    return false;
  }
  if (const std::string refusal = port_->start(profile_.transfers, *this); !refusal.empty()) {
    failure = {LinkError::identity, refusal, true};
    return false;
  }
  // A board that only answers may have sent its first report to somebody else: zero asks for one.
  Duration most = profile_.report_timeout * 10;
  if (profile_.asks_first) {
    LinkFailure ignored;
    if (!wait_for_report(profile_.report_timeout, ignored) && ignored.error == LinkError::timeout) send({});
    if (ignored.error != LinkError::none && ignored.error != LinkError::timeout) {
      failure = ignored;
      most = Duration{};
    }
  }
  if (failure.error == LinkError::none && wait_for_report(most, failure)) return true;
  if (any_wrong_) {
    failure.error = LinkError::identity;
    failure.text += ", so it is another device with the same USB numbers";
  }
  failure.reopen = true;
  return false;
}

bool UsbLink::find_zero(LinkFailure& failure) {
  if (profile_.calibration.empty()) return true;
  std::string why = uncalibrated(profile_);
  try {
    if (const auto counts = store_.find(port_->identity(), zero_.size())) {
      zero_ = *counts;
      return true;
    }
  } catch (const RunError& error) {
    why = std::string("its calibration is not valid: ") + error.what();
  }
  failure = {LinkError::identity, why, true, true};
  return false;
}

bool UsbLink::open(LinkFailure& failure) {
  failure = {};
  if (open_port(failure) && find_zero(failure) && ask_for_report(profile_.report_timeout * 10, failure)) {
    ended_ = MonotonicClock::now();
    return true;
  }
  port_.reset();
  return false;
}

void UsbLink::read_sample(LinkSample& sample, LinkFailure& failure) const {
  const InputLayout& in = profile_.input;
  sample = {};
  for (std::size_t i = 0; i < in.axes.size(); ++i) {
    const AxisInput& axis = in.axes[i];
    const ReportField& field = in.fields[axis.field];
    // The counter of a calibrated device may begin anew between its zero and here.
    const double span = profile_.calibration.empty() ? 0 : field.span();
    sample.q[i] = axis.scale * count_from(zero_[i], field.read(newest_), span) + axis.offset;
  }
  for (std::size_t i = 0; i < in.buttons.size(); ++i) {
    if (in.buttons[i].is_set(in.fields, newest_)) sample.buttons |= 1U << i;
  }
  for (std::size_t i = 0; i < in.faults.size(); ++i) {
    if (!in.faults[i].is_set(in.fields, newest_)) continue;
    sample.faults |= 1U << i;
    failure.text += (failure.text.empty() ? "the device reports " : ", ") + in.faults[i].meaning;
  }
}

bool UsbLink::exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) {
  TACTOR_DEMAND(port_ != nullptr);
  failure = {};
  const double frame = 1 / profile_.rate;
  const Instant began = MonotonicClock::now();
  const bool paused = began - ended_ > Duration::from_seconds(pause_frames * frame);
  if (out_of_step_) {
    if (!drain(failure)) return false;
  } else if ((paused || port_->sending()) && !wait(Duration{}, failure)) {
    return false;
  }
  if (paused) {
    // What came meanwhile shows where the device was then, and what it sends on its own has one more ready.
    fresh_ = false;
    unwanted_ = profile_.asks_first ? 0 : 1;
  }
  any_wrong_ = false;
  send(command);
  const bool good = wait_for_report(profile_.report_timeout, failure, profile_.asks_first ? &command : nullptr);
  ended_ = MonotonicClock::now();
  slow_ = ended_ - began > Duration::from_seconds(slow_frames * frame) ? slow_ + 1 : 0;
  if (profile_.asks_first && (!good || slow_ >= most_slow_cycles)) {
    out_of_step_ = true;
    slow_ = 0;
  }
  if (!good) return false;
  fresh_ = false;
  read_sample(sample, failure);
  return true;
}

void UsbLink::close() {
  if (port_ == nullptr) return;
  const Instant end = MonotonicClock::now() + longest_goodbye;
  bool gone = false;
  const auto wait_while = [&](const auto& waits) {
    while (waits() && !gone && MonotonicClock::now() < end) {
      gone = port_->wait(Duration{10'000'000}) == UsbResult::disconnected;
    }
  };
  const auto sending = [this] { return port_->sending(); };
  // Zero must be the last thing that is sent, after what is on its way.
  wait_while(sending);
  if (!gone) send({});
  wait_while(sending);
  // A board that only answers looks for the zero after its reports have been taken, and not before.
  if (profile_.asks_first) wait_while([this] { return unanswered_ > 0; });
  port_.reset();
}

std::vector<double> UsbLink::calibrate(Duration still) {
  LinkFailure failure;
  if (!open_port(failure)) {
    port_.reset();
    throw RunError(name_ + ": " + failure.text);
  }
  const std::size_t n = profile_.input.axes.size();
  const auto count = [&](std::size_t i) { return profile_.input.fields[profile_.input.axes[i].field].read(newest_); };
  std::vector<double> first(n), least(n, 0.0), most(n, 0.0);
  const auto ask = [&] {
    if (ask_for_report(profile_.report_timeout * 10, failure)) return;
    port_.reset();
    throw RunError(name_ + ": " + failure.text);
  };
  ask();
  for (std::size_t i = 0; i < n; ++i) first[i] = count(i);
  const Instant end = MonotonicClock::now() + still;
  while (MonotonicClock::now() < end) {
    ask();
    for (std::size_t i = 0; i < n; ++i) {
      const double span = profile_.input.fields[profile_.input.axes[i].field].span();
      const double moved = count_from(first[i], count(i), span);
      least[i] = std::min(least[i], moved);
      most[i] = std::max(most[i], moved);
    }
  }
  const std::string identity = port_->identity();
  close();
  for (std::size_t i = 0; i < n; ++i) {
    if (most[i] - least[i] > still_counts) {
      throw InputError(name_ + ": the handle was moved while its zero was taken (axis " + profile_.axes[i].name +
                       " by " + std::to_string(static_cast<int>(most[i] - least[i])) +
                       " counts); hold it still in its pose (" + profile_.calibration + ") and calibrate again");
    }
  }
  store_.keep(identity, first);
  return first;
}

}  // namespace tactor
