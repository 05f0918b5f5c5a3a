#include "devices/simulated/simulated.hpp"

#include <algorithm>
#include <sstream>
#include <string>

#include "framework/core/check.hpp"
#include "framework/core/random.hpp"
#include "framework/core/tool_weight.hpp"

namespace tactor {

namespace {

/// Room for the path of half an hour at 1 kHz.
constexpr double max_path_samples = 2e6;
/// A target older than this is not moved on along its velocity; the same in a reference run, whatever its rate.
constexpr Duration longest_extrapolation{20'000'000};

/// A line of that many ticks takes more memory than it is worth.
constexpr double max_line_ticks = 1e5;
/// A hand behind a grip is a body of its own. Lighter bodies cost the exact step of a stiff grip its digits.
constexpr double least_gripped_mass = 1e-3;     // kg
constexpr double least_gripped_inertia = 1e-7;  // kg m^2

DeviceState to_message(const MotionState& motion) {
  DeviceState message;
  message.X_WD = motion.X;
  message.V_WD = motion.V;
  return message;
}

TransmissionParameters link_of(const SimulatedDevice::Params& params) {
  return transmission_of(params.mass, params.motor_share, params.mode_frequency, params.mode_damping, params.backlash);
}

Handle handle_of(const SimulatedDevice::Params& params, bool rotate) {
  return Handle({.inertia = params.mass + params.hand_mass,
                 .damping = params.damping,
                 .coulomb = params.friction,
                 .hand_damping = params.hand_damping,
                 .hand_stiffness = params.hand_stiffness,
                 .breakaway = params.breakaway,
                 .stribeck_velocity = params.stribeck_velocity,
                 .hand_inertia = params.hand_mass,
                 .grip_stiffness = params.grip_stiffness,
                 .grip_damping = params.grip_damping},
                {.inertia = params.inertia + params.hand_inertia,
                 .damping = params.damping_angle,
                 .coulomb = params.friction_angle,
                 .hand_damping = params.hand_damping_angle,
                 .hand_stiffness = params.hand_stiffness_angle,
                 .breakaway = params.breakaway_angle,
                 .stribeck_velocity = params.stribeck_velocity_angle,
                 .hand_inertia = params.hand_inertia,
                 .grip_stiffness = params.grip_stiffness_angle,
                 .grip_damping = params.grip_damping_angle},
                params.sub_step, rotate,
                {.amplifier = {.bandwidth = params.amplifier_bandwidth,
                               .force_max = params.motor_force_max,
                               .torque_max = params.motor_torque_max},
                 .cogging = {.force = params.cogging, .period = params.cogging_period},
                 .transmission = link_of(params)});
}

Encoder encoder_of(const SimulatedDevice::Params& params, const NodeContext& context) {
  return Encoder({.step = params.encoder_step,
                  .step_angle = params.encoder_step_angle,
                  .velocity = params,
                  .noise = params.encoder_noise,
                  .noise_angle = params.encoder_noise_angle,
                  .seed = derive_seed(context.seed, "encoder"),
                  .interval = 1 / params.rate},
                 context.torque);
}

std::size_t line_ticks(const char* name, double delay, double rate) {
  if (delay * rate > max_line_ticks) {
    throw InputError(std::string(name) + " is too many ticks: expected at most " +
                     std::to_string(max_line_ticks / rate) + " s at this rate, found " + std::to_string(delay) + " s");
  }
  const std::size_t ticks = delay_in_ticks(delay, rate);
  if (delay > 0 && ticks == 0) {
    throw InputError(std::string(name) + " is less than half a tick: expected 0 s or at least " +
                     std::to_string(0.5 / rate) + " s at this rate, found " + std::to_string(delay) + " s");
  }
  return ticks;
}

/// So long a command is foreseen to act where the motors keep it for ever: a tick may be missed.
constexpr int foreseen_ticks = 2;
/// A torque counts as a force at this lever, an angle as that much way.
constexpr double lever = 0.05;  // m

LineEnergyOptions line_energy_of(const SimulatedDevice::Params& params, const NodeContext& context) {
  const Duration period = Duration::from_rate(params.rate);
  const double step = params.encoder_step, angle = params.encoder_step_angle;
  const auto delay = [&](const char* name, double time) {
    return period * static_cast<std::int64_t>(line_ticks(name, time, params.rate));
  };
  return {.axes = context.torque ? 6 : 3,
          .lever = {1, 1, 1, lever, lever, lever, 1, 1},
          .step = {step, step, step, angle, angle, angle},
          .period = period,
          .delay_in = delay("delay_in", params.delay_in),
          .delay_out = delay("delay_out", params.delay_out),
          .held = period * (params.command_ticks > 0 ? params.command_ticks : foreseen_ticks),
          .lets_go = params.command_ticks > 0,
          .acceleration = params.handle_acceleration,
          .slew = context.torque ? std::min(params.force_slew, params.torque_slew / lever) : params.force_slew,
          .bounds = params.energy_bound};
}

SimulatedLine line_of(const SimulatedDevice::Params& params, const NodeContext& context) {
  return {line_ticks("delay_in", params.delay_in, params.rate), line_ticks("delay_out", params.delay_out, params.rate),
          line_energy_of(params, context), params.tool_weight ? tool_weight(*context.scene) : Vec3{}, context.torque};
}

void check_gripped(const char* grip, const char* name, const char* unit, bool has_grip, double found, double least) {
  if (!has_grip || found >= least) return;
  std::ostringstream text;
  text << name << " is too small for a grip: expected at least " << least << ' ' << unit << " where " << grip
       << " or its damping is above 0, found " << found << ' ' << unit
       << "; give it more, or make the grip rigid with both 0";
  throw InputError(text.str());
}

}  // namespace

SimulatedDevice::SimulatedDevice(const Params& params, const NodeContext& context)
    : DeviceNode(params, context, 0),
      params_(params),
      handle_(handle_of(params, context.torque)),
      encoder_(encoder_of(params, context)),
      line_(line_of(params, context)) {
  if (params_.backlash > 0 && params_.mode_frequency <= 0) {
    throw InputError(
        "backlash needs mode_frequency for the stiffness at its ends: expected mode_frequency above 0 Hz, found 0 Hz");
  }
  check_gripped("grip_stiffness", "hand_mass", "kg", params.grip_stiffness > 0 || params.grip_damping > 0,
                params.hand_mass, least_gripped_mass);
  const bool turns = params.grip_stiffness_angle > 0 || params.grip_damping_angle > 0;
  check_gripped("grip_stiffness_angle", "hand_inertia", "kg m^2", turns, params.hand_inertia, least_gripped_inertia);
  check_gripped("grip_stiffness_angle", "inertia", "kg m^2", turns, params.inertia, least_gripped_inertia);
  // No reference run follows a run that goes on until it is stopped.
  if (params_.loop == Loop::closed && context.duration != until_stopped) {
    const double samples = context.duration.seconds() * params_.rate + 2;
    // Written once, so that the loop of a device faults no page in where memory is not locked.
    path_.resize(static_cast<std::size_t>(std::min(samples, max_path_samples)));
    path_.clear();
  }
}

LinearDevice linear_device(const SimulatedDevice::Params& params) {
  return {.hold = 1 / params.rate,
          .delay = static_cast<double>(delay_in_ticks(params.delay_out, params.rate)) / params.rate,
          .bandwidth = params.amplifier_bandwidth,
          .mass = params.mass + params.hand_mass,
          .damping = params.damping,
          .hand_damping = params.hand_damping,
          .hand_stiffness = params.hand_stiffness,
          .hand_mass = params.hand_mass,
          .grip_stiffness = params.grip_stiffness,
          .grip_damping = params.grip_damping,
          .transmission = link_of(params)};
}

MotionState SimulatedDevice::target_at(Time now) const {
  const Stamped<Target>& newest = *target.latest();
  MotionState result{newest.value.X_WH, newest.value.V_WH};
  // A target of an earlier tick (two clocks, a lost message) is moved on, so that the handle does not stand and jump.
  const double age = (now - newest.stamp.valid).seconds();
  if (age > 0 && age <= longest_extrapolation.seconds()) {
    result.X.p += age * result.V.v;
    if (rotates()) result.X.R = from_rotation_vector(age * result.V.w) * result.X.R;
  }
  return result;
}

MotionState SimulatedDevice::followed_at(Time now) {
  while (followed_leg_ + 2 < followed_.size() && followed_[followed_leg_ + 1].t <= now) ++followed_leg_;
  const Sample& a = followed_[followed_leg_];
  if (followed_.size() == 1 || now <= a.t) return a.motion;
  const Sample& b = followed_[followed_leg_ + 1];
  if (now >= b.t) return b.motion;
  const double dt = (b.t - a.t).seconds();
  return interpolate(a.motion, b.motion, dt, (now - a.t).seconds() / dt, rotates());
}

/// When the motors let go of the command of the last tick, and of what is on the line; none: they still have it.
std::optional<Time> SimulatedDevice::expiry(Time now) const {
  const double late = params_.command_ticks + 0.5;
  if (params_.command_ticks == 0 || !started_ || !line_.acts() || (now - last_).seconds() * params_.rate < late) {
    return std::nullopt;
  }
  return last_ + Duration::from_rate(params_.rate) * params_.command_ticks;
}

void SimulatedDevice::move_handle(Time now, const MotionState& to) {
  const double dt = started_ ? (now - last_).seconds() : 0;
  if (follows_) {
    handle_.advance_amplifier(dt, line_.held());
    motion_ = encoded_ = followed_at(now);
    return;
  }
  if (params_.loop == Loop::open) {
    handle_.advance_amplifier(dt, line_.held());
    motion_ = encoded_ = to;
    return;
  }
  if (!started_) {
    handle_.place(to);
  } else {
    handle_.advance(dt, line_.held(), target_state_, to);
  }
  motion_ = handle_.state();
  encoded_ = handle_.motor_side();
  target_state_ = to;
  energy_generated_ = std::max(energy_generated_, handle_.work());
  max_speed_ = std::max(max_speed_, norm(motion_.V.v));
  keep_on_path(now);
}

void SimulatedDevice::keep_on_path(Time now) {
  if (path_.capacity() == 0) return;
  if (path_.size() < path_.capacity()) {
    path_.push_back({now, motion_});
  } else {
    ++unkept_;
  }
}

ReadResult SimulatedDevice::read(Time now, DeviceSample& sample) noexcept {
  if (target.latest() == nullptr) return ReadResult::not_yet;
  const MotionState to = target_at(now);
  const std::optional<Time> expired = expiry(now);
  if (expired) {
    const double dt = (now - last_).seconds();
    const double share = (*expired - last_).seconds() / dt;
    move_handle(*expired, interpolate(target_state_, to, dt, share, rotates()));
    last_ = *expired;
    line_.let_go(*expired);
  }
  move_handle(now, to);
  truth.send(now, to_message(motion_));
  motors.send(now, handle_.amplifier().output());
  if (handle_.amplifier().saturated()) ++saturated_ticks_;
  const ShownMotion shown{encoder_.read(encoded_, now), now};
  // Before the first sample has come over the line, the handle is taken to have been where that one says.
  if (!started_) line_.fill(shown);
  sample = {to_message(line_.receive(shown, observes_port())), now};
  sample.expired = expired.has_value();
  started_ = true;
  last_ = now;
  return ReadResult::sample;
}

bool SimulatedDevice::write(Time now, const Wrench& commanded_D_W) noexcept {
  line_.send(now, commanded_D_W, gate().gain(), observes_port());
  return true;
}

std::optional<LineTotals> SimulatedDevice::line_totals() const {
  const LineTotals totals = line_.totals();
  return observes_port() && totals.counted ? std::optional(totals) : std::nullopt;
}

const char* SimulatedDevice::failure() const noexcept {
  return "the handle's target is not finite";
}

void SimulatedDevice::follow(const Node& tested) {
  const auto* device = dynamic_cast<const SimulatedDevice*>(&tested);
  TACTOR_DEMAND(device != nullptr);
  if (device->params_.loop != Loop::closed || device->path_.empty()) return;
  followed_ = device->path_;
  followed_leg_ = 0;
  follows_ = true;
}

void SimulatedDevice::report(Report& report) const {
  if (const auto share = encoder_.mixed_share()) report.set("device.velocity_mixed_share", *share);
}

}  // namespace tactor
