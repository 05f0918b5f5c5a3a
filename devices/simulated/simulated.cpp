#include "devices/simulated/simulated.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/realtime/declare_device.hpp"

namespace tactor {

namespace {

/// Room for the path of half an hour at 1 kHz.
constexpr double max_path_samples = 2e6;
/// A target older than this is not moved on along its velocity; the same in a reference run, whatever its rate.
constexpr Duration longest_extrapolation{20'000'000};

DeviceState to_message(const MotionState& motion) {
  DeviceState message;
  message.X_WD = motion.X;
  message.V_WD = motion.V;
  return message;
}

}  // namespace

SimulatedDevice::SimulatedDevice(const Params& params, const NodeContext& context)
    : DeviceNode(params, context),
      params_(params),
      handle_({.inertia = params.mass + params.hand_mass,
               .damping = params.damping,
               .coulomb = params.friction,
               .hand_damping = params.hand_damping,
               .hand_stiffness = params.hand_stiffness},
              {.inertia = params.inertia + params.hand_inertia,
               .damping = params.damping_angle,
               .coulomb = params.friction_angle,
               .hand_damping = params.hand_damping_angle,
               .hand_stiffness = params.hand_stiffness_angle},
              params.sub_step, context.torque),
      encoder_(params.encoder_step, params.encoder_step_angle, params.velocity_departure,
               params.velocity_departure_angle, context.torque) {
  if (params_.loop == Loop::closed) {
    const double samples = context.duration.seconds() * params_.rate + 2;
    // Written once, so that the loop of a device faults no page in where memory is not locked.
    path_.resize(static_cast<std::size_t>(std::min(samples, max_path_samples)));
    path_.clear();
  }
}

NodeInfo SimulatedDevice::declare() {
  using D = SimulatedDevice;
  Declare<D> declaration("device.simulated", "A haptic device and the hand on it, in software.");
  declaration
      .details(
          "Each tick it moves the handle, shows its state through encoders and commands the force of the newest "
          "segment, as far as the safety gate lets it through. Open loop: the handle is where the target says. Closed "
          "loop: handle and hand are one body, M a = F - b v - friction + b_h (v_T - v) + k_h (x_T - x), driven by the "
          "commanded force, held from tick to tick, and by the hand towards the target; rotation alike. Mass, damping "
          "and stiffness of the hand default to the usual 0.55 kg, 6.5 N s/m, 135 N/m. A reference run follows the "
          "path of the run under test.")
      .input("target", &D::target, {.doc = "where the hand is to be"});
  declare_device(declaration);
  const auto not_closed = [](const Params& params, const MetricUse&) {
    return std::string(params.loop == Loop::closed ? "" : "loop is open");
  };
  declaration
      .metric("device.energy_generated_J", "J", "most energy that the commanded wrench had given to the handle, net",
              Better::lower)
      .left_out_when(not_closed)
      .metric("device.max_speed_m_per_s", "m/s", "largest speed of the handle", Better::neither)
      .left_out_when(not_closed)
      .metric("device.unkept_path_samples", "1", "ticks beyond those whose path is kept for the reference run",
              Better::lower)
      .left_out_when(not_closed);
  declaration.output("truth", &D::truth, "the handle as it is")
      .choice("loop", &Params::loop, {{"open", Loop::open}, {"closed", Loop::closed}}, std::optional(Loop::open),
              "whether the commanded force moves the handle")
      .real("encoder_step", &Params::encoder_step,
            {.doc = "step of the position encoders; 0 for none",
             .unit = "m",
             .default_value = 1e-5,
             .min = 0,
             .max = 1e-2,
             .in_reference = 0})
      .real("encoder_step_angle", &Params::encoder_step_angle,
            {.doc = "step of the angle encoders; 0 for none",
             .unit = "rad",
             .default_value = 1e-4,
             .min = 0,
             .max = 0.1,
             .in_reference = 0})
      .real("velocity_departure", &Params::velocity_departure,
            {.doc = "how far the handle departs from constant acceleration in 10 ms, for the filter that estimates its "
                    "velocity: less is smoother and later",
             .unit = "m",
             .default_value = 2e-6,
             .min = 0,
             .max = 1,
             .above_min = true})
      .real("velocity_departure_angle", &Params::velocity_departure_angle,
            {.doc = "the same of its rotation",
             .unit = "rad",
             .default_value = 2e-5,
             .min = 0,
             .max = 10,
             .above_min = true})
      .real("mass", &Params::mass,
            {.doc = "mass of the handle", .unit = "kg", .default_value = 0.1, .min = 0.001, .max = 100})
      .real("damping", &Params::damping,
            {.doc = "viscous friction of the handle", .unit = "N s/m", .default_value = 0.2, .min = 0, .max = 1000})
      .real("friction", &Params::friction,
            {.doc = "Coulomb friction of the handle", .unit = "N", .default_value = 0.05, .min = 0, .max = 100})
      .real("hand_mass", &Params::hand_mass,
            {.doc = "mass of the hand", .unit = "kg", .default_value = 0.55, .min = 0, .max = 100})
      .real("hand_damping", &Params::hand_damping,
            {.doc = "damping of the hand towards its target",
             .unit = "N s/m",
             .default_value = 6.5,
             .min = 0,
             .max = 1e4})
      .real("hand_stiffness", &Params::hand_stiffness,
            {.doc = "stiffness of the hand towards its target",
             .unit = "N/m",
             .default_value = 135,
             .min = 0,
             .max = 1e6})
      .real("inertia", &Params::inertia,
            {.doc = "inertia of the handle",
             .unit = "kg m^2",
             .default_value = 5e-5,
             .min = 0,
             .max = 10,
             .above_min = true})
      .real("damping_angle", &Params::damping_angle,
            {.doc = "viscous friction of the handle's rotation",
             .unit = "N m s/rad",
             .default_value = 1e-4,
             .min = 0,
             .max = 10})
      .real("friction_angle", &Params::friction_angle,
            {.doc = "Coulomb friction of the handle's rotation",
             .unit = "N m",
             .default_value = 1e-3,
             .min = 0,
             .max = 10})
      .real("hand_inertia", &Params::hand_inertia,
            {.doc = "inertia of the hand", .unit = "kg m^2", .default_value = 5e-4, .min = 0, .max = 10})
      .real("hand_damping_angle", &Params::hand_damping_angle,
            {.doc = "damping of the hand's rotation towards its target",
             .unit = "N m s/rad",
             .default_value = 0.01,
             .min = 0,
             .max = 100})
      .real("hand_stiffness_angle", &Params::hand_stiffness_angle,
            {.doc = "stiffness of the hand's rotation towards its target",
             .unit = "N m/rad",
             .default_value = 0.5,
             .min = 0,
             .max = 1e4})
      .real("sub_step", &Params::sub_step,
            {.doc = "longest step of the closed loop's integration",
             .unit = "s",
             .default_value = 1e-4,
             .min = 0,
             .max = 1e-2,
             .above_min = true});
  return declaration.info();
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

void SimulatedDevice::move_handle(Time now) {
  if (follows_) {
    motion_ = followed_at(now);
    return;
  }
  const MotionState to = target_at(now);
  if (params_.loop == Loop::open) {
    motion_ = to;
    return;
  }
  if (!started_) {
    handle_.place(to);
  } else {
    handle_.advance((now - last_).seconds(), held_D_W_, target_state_, to);
  }
  const MotionState& moved = handle_.state();
  if (started_) {
    // The force was held, so force times way is its work exactly.
    energy_ += dot(held_D_W_.force, moved.X.p - motion_.X.p);
    if (rotates()) energy_ += dot(held_D_W_.torque, to_rotation_vector(moved.X.R * inverse(motion_.X.R)));
    energy_generated_ = std::max(energy_generated_, energy_);
  }
  motion_ = moved;
  target_state_ = to;
  max_speed_ = std::max(max_speed_, norm(motion_.V.v));
  keep_on_path(now);
}

void SimulatedDevice::keep_on_path(Time now) {
  if (path_.size() < path_.capacity()) {
    path_.push_back({now, motion_});
  } else {
    ++unkept_;
  }
}

ReadResult SimulatedDevice::read(Time now, DeviceSample& sample) noexcept {
  if (target.latest() == nullptr) return ReadResult::not_yet;
  move_handle(now);
  started_ = true;
  last_ = now;
  truth.send(now, to_message(motion_));
  sample = {to_message(encoder_.read(motion_, now)), now};
  return ReadResult::sample;
}

bool SimulatedDevice::write(Time, const Wrench& commanded_D_W) noexcept {
  held_D_W_ = commanded_D_W;
  return true;
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
  DeviceNode::report(report);
  if (params_.loop != Loop::closed || follows_) return;
  report.set("device.energy_generated_J", energy_generated_);
  report.set("device.max_speed_m_per_s", max_speed_);
  report.set("device.unkept_path_samples", static_cast<double>(unkept_));
}

}  // namespace tactor
