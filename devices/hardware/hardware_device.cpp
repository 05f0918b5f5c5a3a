#include "devices/hardware/hardware_device.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

#include "framework/core/check.hpp"
#include "framework/core/tool_weight.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

namespace {

constexpr Duration absent_after{1'000'000'000};  // without a line that opens
constexpr Duration look_for_it{2'000'000};

Vec3 as_vector(const std::vector<double>& v) {
  TACTOR_DEMAND(v.size() == 3);
  return {v[0], v[1], v[2]};
}

double noise_of(double resolution) {
  return std::max(resolution, 1e-9) / std::sqrt(12.0);
}

/// In Hz, of the poles of a MotionModel of order 3 where samples come at `rate`: s^6 = -q / (noise^2 T), with q = 20
/// departure^2 / (10 ms)^5.
double cutoff(double departure, double noise, double rate) {
  const double density = 20 * departure * departure / std::pow(0.01, 5);
  return std::pow(density * rate / (noise * noise), 1.0 / 6.0) / (2 * std::numbers::pi);
}

AxisLimits with(AxisLimits limits, Duration stuck_after) {
  limits.stuck_after = stuck_after;
  return limits;
}

/// A device that shows a pose: a torque counts as a force at this lever.
constexpr double turn = 0.05;  // m

LineEnergyOptions energy_of(const HardwareParams& params, const HardwareParts& parts) {
  LineEnergyOptions options;
  options.axes = parts.limits.axes;
  options.lever = every_axis(parts.kinematics ? parts.kinematics->lever() : 1);
  for (std::size_t a = 3; parts.limits.turns() && a < 6; ++a) options.lever[a] = turn;
  for (std::size_t a = 0; a < max_axes; ++a) {
    const bool turns = parts.limits.turns() && a >= 3 && a < 6;
    options.step[a] = turns ? parts.resolution_angle : parts.resolution / options.lever[a];
  }
  if (const int gripper = parts.limits.gripper(); gripper >= 0) {
    options.lever[static_cast<std::size_t>(gripper)] = 1;
    options.step[static_cast<std::size_t>(gripper)] = parts.resolution_gripper;
  }
  options.period = Duration::from_rate(parts.rate);
  options.delay_in = parts.delay_in;
  options.delay_out = parts.delay_out;
  options.held = options.period * 2;
  options.acceleration = params.handle_acceleration;
  options.slew = params.force_scale * std::min(params.force_slew, params.torque_slew / turn);
  options.bounds = params.energy_bound;
  return options;
}

/// `NAME: 3 timeout, 1 crc, opened anew 1 times; the last: TEXT`, so that a run that recovered tells of which device
/// its counts are. Empty: nothing failed.
std::string tell_failures(const DeviceLine& runner) {
  std::string last = runner.last_failure();
  if (last.empty()) return {};
  const LinkMetrics& line = runner.metrics();
  std::string counts;
  for (int i = 1; i < link_error_count; ++i) {
    const auto error = static_cast<LinkError>(i);
    if (line.errors(error) == 0) continue;
    counts += (counts.empty() ? "" : ", ") + std::to_string(line.errors(error)) + " " + std::string(name_of(error));
  }
  const std::string name = runner.name() + ": ";
  if (last.starts_with(name)) last.erase(0, name.size());
  return name + counts + ", opened anew " + std::to_string(line.reconnects.value()) + " times; the last: " + last;
}

LinkRunnerSettings runner_settings(const HardwareParams& params, const HardwareParts& parts,
                                   const NodeContext& context) {
  LinkRunnerSettings settings;
  settings.rate = parts.rate;
  // A command holds for two cycles of the slower of loop and line.
  settings.commands.expires_after = Duration::from_seconds(2 / std::min(params.rate, parts.rate));
  settings.energy = energy_of(params, parts);
  settings.thread_name = "link-" + context.name;
  settings.flight = {context.flight, context.index};
  return settings;
}

/// By axis at most twice what the gate of the loop lets through, so that only a command that did not pass it is
/// changed. Of geometries whose levers are not known the time from zero to the largest effort is taken instead.
AxisValues slew_of(const HardwareParams& params, const HardwareParts& parts) {
  constexpr double room = 2, shortest_rise = 2e-3;
  AxisValues slew = every_axis(LinkLimits::unknown);
  for (std::size_t a = 0; a < static_cast<std::size_t>(parts.limits.axes); ++a) {
    const bool is_gripper = static_cast<int>(a) == parts.limits.gripper();
    if (is_gripper || (parts.kinematics && parts.kinematics->lever() != 1)) {
      slew[a] = parts.limits.effort_max[a] / shortest_rise;
    } else {
      slew[a] = room * params.force_scale * (parts.limits.turns() && a >= 3 ? params.torque_slew : params.force_slew);
    }
  }
  return slew;
}

GuardConfig guard_config(const HardwareParams& params, const HardwareParts& parts, const AxisLimits& limits,
                         const LinkRunnerSettings& settings) {
  constexpr double periods = 2;
  constexpr Duration least{2'000'000}, margin{50'000'000};
  GuardConfig config;
  config.layout = guard_layout;
  config.line = parts.guardable->line;
  config.link = parts.guardable->link;
  config.limits = limits;
  config.rate = settings.rate;
  config.expires_after = std::max(least, Duration::from_seconds(periods / params.rate));
  config.age_max = std::max(settings.commands.age_max, config.expires_after + config.let_go);
  config.energy = settings.energy;
  config.gate.slew = slew_of(params, parts);
  config.gate.continuous = parts.effort_continuous;
  config.gate.thermal_time = parts.thermal_time;
  config.gate.patience = params.ramp_down_time + params.brake_time + margin;
  config.gate.let_go = config.let_go;
  config.gate.speed = true;
  config.thread_name = settings.thread_name;
  return config;
}

}  // namespace

bool needs_guard(GuardChoice choice, const HardwareParts& parts) {
  constexpr Duration fast{100'000'000};
  if (choice == GuardChoice::off) return false;
  if (choice == GuardChoice::automatic) return parts.guardable && !(parts.watchdog && *parts.watchdog < fast);
  if (parts.guardable) return true;
  throw ValueError("guard",
                   "guard: expected auto or off, because the line of this device cannot run in a process of its own, "
                   "found on");
}

HardwareDevice::HardwareDevice(const HardwareParams& params, const NodeContext& context, HardwareParts parts)
    : DeviceNode(params, context, parts.buttons),
      params_(params),
      workspace_{params.workspace_scale, params.force_scale, from_rotation_vector(as_vector(params.rotation)),
                 as_vector(params.origin)},
      weight_W_(params.tool_weight ? tool_weight(*context.scene) : Vec3{}),
      period_of_line_(Duration::from_rate(parts.rate)),
      filter_(params, noise_of(parts.resolution * params.workspace_scale), noise_of(parts.resolution_angle),
              1 / std::min(parts.rate, params.rate), context.torque),
      cutoff_Hz_(cutoff(params.velocity_departure, noise_of(parts.resolution * params.workspace_scale), parts.rate)),
      age_(std::make_unique<LatencyHistogram>()),
      path_(context.duration, params.rate) {
  const AxisLimits limits = with(parts.limits, params.stuck_after);
  check(limits);
  TACTOR_DEMAND(limits.pose == (parts.kinematics == nullptr));
  TACTOR_DEMAND(parts.status >= 0 && parts.status <= max_status);
  const LinkRunnerSettings settings = runner_settings(params, parts, context);
  if (needs_guard(params.guard, parts)) {
    GuardConfig config = guard_config(params, parts, limits, settings);
    runner_ = std::make_unique<GuardedLine>(std::move(parts.link), std::move(config), settings.flight);
  } else {
    runner_ = std::make_unique<LinkRunner>(std::move(parts.link), limits, settings);
  }
  kinematics_ = std::move(parts.kinematics);
  TACTOR_DEMAND(limits.pose || kinematics_->axes() == limits.handle_axes());
  if (limits.gripper() >= 0) {
    gripper_.emplace(params, noise_of(parts.resolution_gripper), 1 / std::min(parts.rate, params.rate));
  }
  status_.count = most_.count = parts.status;
}

HardwareDevice::~HardwareDevice() = default;

void HardwareDevice::start(StepContext&) {
  started_ = MonotonicClock::now();
  if (followed_) return;
  runner_->start();
  // A line that is still being opened, with a start-up or a homing, is waited for by the run itself.
  const Instant give_up = started_ + std::min(params_.connect_timeout, absent_after);
  while (report_.samples == 0 && !report_.asks_user && MonotonicClock::now() < give_up) {
    MonotonicClock::sleep_until(MonotonicClock::now() + look_for_it);
    runner_->newest(report_);
  }
  if (report_.cuts > 0 || report_.error == LinkError::none) return;
  runner_->stop();
  if (report_.asks_user) throw InputError(runner_->last_failure());
  throw RunError("cannot be reached: " + runner_->last_failure());
}

void HardwareDevice::follow(const Node& tested) {
  const auto* device = dynamic_cast<const HardwareDevice*>(&tested);
  TACTOR_DEMAND(device != nullptr);
  followed_ = device->path_;
}

ReadResult HardwareDevice::fail(const char* format, ...) noexcept {
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(failure_.data(), failure_.size(), format, arguments);
  va_end(arguments);
  return ReadResult::failed;
}

ReadResult HardwareDevice::not_connected(Instant clock) noexcept {
  if (clock - started_ < params_.connect_timeout) return ReadResult::not_yet;
  const char* why = report_.text[0] != '\0' ? report_.text.data() : runner_->name().c_str();
  return fail("no sample within %.3g s of the start: %s", params_.connect_timeout.seconds(), why);
}

void HardwareDevice::take_in(Time now, Instant clock) noexcept {
  if (report_.samples == samples_seen_) return;
  const bool first = samples_seen_ == 0;
  samples_seen_ = report_.samples;
  // A sample's time in the run; a tick that woke late must not turn the order round.
  Time t{std::max<std::int64_t>(0, now.ns - (clock - report_.sampled).ns)};
  if (!first) t = std::max(t, newest_.time + Duration{1});
  tell_status(t);
  Pose X_BD;
  has_pose_ = pose_of(report_.sample, X_BD);
  if (report_.verdict == Plausibility::Verdict::jumped || !has_pose_) return;
  newest_.time = t;
  newest_.state.X_WD = workspace_.to_scene(X_BD);
  filter_.take(newest_.state.X_WD, t);
  newest_.state.V_WD = filter_.velocity();
  newest_.state.buttons = static_cast<std::int32_t>(report_.sample.buttons);
  newest_.in_workspace = report_.limits.contains(report_.sample.q);
  if (gripper_) {
    const auto axis = static_cast<std::size_t>(report_.limits.gripper());
    gripper.send(t, gripper_->take(report_.sample.q[axis], t));
  }
}

bool HardwareDevice::pose_of(const LinkSample& shown, Pose& X_BD) noexcept {
  if (kinematics_) return kinematics_->forward(shown.q, X_BD);
  X_BD = {{shown.q[0], shown.q[1], shown.q[2]}, report_.limits.turns() ? shown.R_BD : Quat{}};
  return is_finite(X_BD.p);
}

void HardwareDevice::tell_status(Time t) noexcept {
  const auto count = static_cast<std::size_t>(status_.count);
  bool changed = samples_seen_ == 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double value = report_.sample.status[i];
    most_.value[i] = samples_seen_ == 1 ? value : std::max(most_.value[i], value);
    changed = changed || value != status_.value[i];
    status_.value[i] = value;
  }
  if (count > 0 && changed) status.send(t, status_);
}

ReadResult HardwareDevice::judged() noexcept {
  const Plausibility::Finding& f = report_.finding;
  const char* name = runner_->name().c_str();
  if (report_.hold != GateHold::none)
    return fail("%s: the guard holds the force back: %s", name, words_of(report_.hold));
  if (report_.sample.faults != 0) return fail("%s", report_.text.data());
  if (report_.verdict == Plausibility::Verdict::jumped && report_.limits.turns() && f.axis >= 3 && f.axis < 6) {
    return fail("%s: its orientation jumped by %.3g rad in %.3g ms and is not believed", name, f.to,
                f.time.seconds() * 1e3);
  }
  if (report_.verdict == Plausibility::Verdict::jumped) {
    return fail("%s: the encoder of axis %d jumped from %.6g to %.6g in %.3g ms and is not believed", name, f.axis + 1,
                f.from, f.to, f.time.seconds() * 1e3);
  }
  if (report_.verdict == Plausibility::Verdict::stuck) {
    return fail("%s: the encoder of axis %d has stood at %.6g for %.3g s under a force: it is stuck", name, f.axis + 1,
                f.from, f.time.seconds());
  }
  if (!has_pose_) return fail("%s: its axes show a position that the device cannot reach", name);
  return ReadResult::sample;
}

ReadResult HardwareDevice::read(Time now, DeviceSample& sample) noexcept {
  if (followed_) {
    if (followed_->empty()) return ReadResult::not_yet;
    sample = {followed_->at(now), now};
    return ReadResult::sample;
  }
  const Instant clock = MonotonicClock::now();
  if (runner_->newest(report_)) take_in(now, clock);
  if (samples_seen_ == 0) return not_connected(clock);
  if (report_.expiries != expiries_seen_) {
    expiries_seen_ = report_.expiries;
    sample.expired = true;
    if (gripper_) gripper_->let_go();
  }
  const Duration age = clock - report_.sampled;
  age_->record(age);
  if (age > params_.link_timeout) {
    // A line whose newest cycle was well is late, not at fault.
    const bool told = report_.error != LinkError::none && report_.text[0] != '\0';
    const char* why = told ? report_.text.data() : runner_->name().c_str();
    return fail("the newest sample is %.0f ms old: %s", age.seconds() * 1e3, why);
  }
  if (report_.cuts != cuts_seen_) {
    const bool first = cuts_seen_ == 0;
    cuts_seen_ = report_.cuts;
    if (!first) return fail("%s: the line was opened anew", runner_->name().c_str());
  }
  if (const ReadResult verdict = judged(); verdict != ReadResult::sample) return verdict;
  const bool expired = sample.expired;
  sample = newest_;
  sample.expired = expired;
  path_.add(newest_);
  return ReadResult::sample;
}

bool HardwareDevice::write(Time now, const Wrench& commanded_D_W) noexcept {
  if (followed_) return true;
  LinkCommand command;
  if (samples_seen_ > 0) {
    efforts_of(commanded_D_W, command.effort);
    // As far as the gate is open.
    if (weight_W_ != Vec3{}) efforts_of({gate().gain() * weight_W_, {}}, command.weight);
    command.return_time = Duration::from_seconds(
        std::max(norm(commanded_D_W.force) / params_.force_slew, norm(commanded_D_W.torque) / params_.torque_slew));
    if (gripper_) {
      const auto axis = static_cast<std::size_t>(report_.limits.gripper());
      command.effort[axis] =
          gripper_->force(now, gripper_force.latest(), gate().gain(), report_.limits.effort_max[axis]);
    }
  }
  runner_->command(MonotonicClock::now(), command);
  return true;
}

void HardwareDevice::efforts_of(const Wrench& F_D_W, AxisValues& effort) noexcept {
  const Wrench F_D_B = workspace_.to_device(F_D_W);
  if (kinematics_) return kinematics_->efforts(report_.sample.q, F_D_B, effort);
  effort = {F_D_B.force.x, F_D_B.force.y, F_D_B.force.z, F_D_B.torque.x, F_D_B.torque.y, F_D_B.torque.z};
}

std::optional<LineTotals> HardwareDevice::line_totals() const {
  return followed_ || !report_.energy.counted ? std::nullopt : std::optional(report_.energy);
}

Pace* HardwareDevice::pace() {
  constexpr double least = 0.8, most = 1.25;
  const double ratio = period_of_line_.seconds() * params_.rate;
  return ratio > least && ratio < most ? runner_->pace() : nullptr;
}

std::optional<double> HardwareDevice::newest_status(std::size_t index) const {
  return samples_seen_ > 0 ? std::optional(status_.value[index]) : std::nullopt;
}

std::optional<double> HardwareDevice::most_status(std::size_t index) const {
  return samples_seen_ > 0 ? std::optional(most_.value[index]) : std::nullopt;
}

ForceAccount HardwareDevice::account() const {
  ForceAccount account = DeviceNode::account();
  if (!followed_) account.carried = static_cast<std::uint64_t>(runner_->metrics().forced_cycles.value());
  return account;
}

void HardwareDevice::report(Report& report) const {
  if (followed_) return;
  const LinkMetrics& line = runner_->metrics();
  const auto count = [&](const std::string& name, auto value) {
    report.set("device." + name, static_cast<double>(value));
  };
  count("link.cycles", line.cycles.value());
  count("link.reconnects", line.reconnects.value());
  count("link.skipped", line.skipped.value());
  for (int i = 1; i < link_error_count; ++i) {
    const auto error = static_cast<LinkError>(i);
    count("link.errors." + std::string(name_of(error)), line.errors(error));
  }
  const auto latency = [&](const std::string& name, const LatencyHistogram& histogram) {
    if (histogram.count() == 0) return;
    report.set("device.link." + name + ".p50", histogram.quantile(0.5).microseconds());
    report.set("device.link." + name + ".p99", histogram.quantile(0.99).microseconds());
    report.set("device.link." + name + ".max", histogram.max().microseconds());
  };
  latency("age_us", *age_);
  latency("cycle_us", line.cycle_time);
  count("jumps", line.jumps.value());
  count("stuck", line.stuck.value());
  count("limited_ticks", line.limited.value());
  count("link.expired", line.expired.value());
  report.set("device.velocity_cutoff_Hz", cutoff_Hz_);
  if (const auto share = filter_.mixed_share()) report.set("device.velocity_mixed_share", *share);
  if (const std::string text = tell_failures(*runner_); !text.empty()) report.remark(text);
  if (failure_[0] != '\0') report.remark("last failed reading: " + std::string(failure_.data()));
  for (const std::string& text : runner_->refused()) report.remark(runner_->name() + ": its line's thread: " + text);
}

}  // namespace tactor
