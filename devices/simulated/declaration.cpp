#include <optional>
#include <string>

#include "devices/simulated/simulated.hpp"
#include "framework/realtime/declare_device.hpp"
#include "framework/realtime/declare_line.hpp"
#include "framework/realtime/declare_velocity.hpp"

namespace tactor {

namespace {

/// Handle and hand, and what lies between them.
void declare_translation(Declare<SimulatedDevice>& declaration) {
  using Params = SimulatedDevice::Params;
  declaration
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
      .real("grip_stiffness", &Params::grip_stiffness,
            {.doc = "stiffness between handle and hand, which makes the hand a body of its own. 0, with grip_damping "
                    "0: rigid",
             .unit = "N/m",
             .default_value = 0,
             .min = 0,
             .max = 1e6})
      .real("grip_damping", &Params::grip_damping,
            {.doc = "damping between handle and hand", .unit = "N s/m", .default_value = 0, .min = 0, .max = 1e4});
}

void declare_rotation(Declare<SimulatedDevice>& declaration) {
  using Params = SimulatedDevice::Params;
  declaration
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
      .real("grip_stiffness_angle", &Params::grip_stiffness_angle,
            {.doc = "stiffness between the rotations of handle and hand; 0, with grip_damping_angle 0: rigid",
             .unit = "N m/rad",
             .default_value = 0,
             .min = 0,
             .max = 1e4})
      .real("grip_damping_angle", &Params::grip_damping_angle,
            {.doc = "damping between the rotations of handle and hand",
             .unit = "N m s/rad",
             .default_value = 0,
             .min = 0,
             .max = 100});
}

void declare_motors(Declare<SimulatedDevice>& declaration) {
  using Params = SimulatedDevice::Params;
  declaration
      .real("amplifier_bandwidth", &Params::amplifier_bandwidth,
            {.doc = "bandwidth of the motors' amplifiers, a first-order pole; 0 for none",
             .unit = "Hz",
             .default_value = 0,
             .min = 0,
             .max = 1e5,
             .in_reference = 0})
      .real("motor_force_max", &Params::motor_force_max,
            {.doc = "largest force of the motors, by norm; 0 for none",
             .unit = "N",
             .default_value = 0,
             .min = 0,
             .max = 1000,
             .in_reference = 0})
      .real("motor_torque_max", &Params::motor_torque_max,
            {.doc = "largest torque of the motors, by norm; 0 for none",
             .unit = "N m",
             .default_value = 0,
             .min = 0,
             .max = 100,
             .in_reference = 0})
      .real("cogging", &Params::cogging,
            {.doc = "amplitude of the motors' force ripple on each axis, a sine of the position; 0 for none",
             .unit = "N",
             .default_value = 0,
             .min = 0,
             .max = 10})
      .real("cogging_period", &Params::cogging_period,
            {.doc = "distance from one rest position of the force ripple to the next",
             .unit = "m",
             .default_value = 5e-3,
             .min = 1e-4,
             .max = 1});
}

void declare_friction(Declare<SimulatedDevice>& declaration) {
  using Params = SimulatedDevice::Params;
  declaration
      .real("breakaway", &Params::breakaway,
            {.doc =
                 "friction that holds the handle at rest, if it is above `friction`; it falls to `friction` with speed",
             .unit = "N",
             .default_value = 0,
             .min = 0,
             .max = 100})
      .real("stribeck_velocity", &Params::stribeck_velocity,
            {.doc = "speed at which the part of `breakaway` above `friction` is down to 1/e",
             .unit = "m/s",
             .default_value = 5e-3,
             .min = 0,
             .max = 10,
             .above_min = true})
      .real("breakaway_angle", &Params::breakaway_angle,
            {.doc = "friction that holds the handle's rotation at rest, if it is above `friction_angle`",
             .unit = "N m",
             .default_value = 0,
             .min = 0,
             .max = 10})
      .real("stribeck_velocity_angle", &Params::stribeck_velocity_angle,
            {.doc = "speed at which the part of `breakaway_angle` above `friction_angle` is down to 1/e",
             .unit = "rad/s",
             .default_value = 0.1,
             .min = 0,
             .max = 100,
             .above_min = true});
}

void declare_transmission(Declare<SimulatedDevice>& declaration) {
  using Params = SimulatedDevice::Params;
  declaration
      .real("mode_frequency", &Params::mode_frequency,
            {.doc = "frequency at which motor side and handle vibrate against each other, without hand and friction; "
                    "0: they move as one",
             .unit = "Hz",
             .default_value = 0,
             .min = 0,
             .max = 5000})
      .real("mode_damping", &Params::mode_damping,
            {.doc = "damping ratio of that vibration", .default_value = 0.05, .min = 0, .max = 10})
      .real("motor_share", &Params::motor_share,
            {.doc = "share of `mass` that is on the motor side, the rest is the handle",
             .default_value = 0.5,
             .min = 0.01,
             .max = 0.99})
      .real("backlash", &Params::backlash,
            {.doc = "play between motor side and handle on each axis, from one end to the other. It needs "
                    "mode_frequency, which gives the stiffness at the ends",
             .unit = "m",
             .default_value = 0,
             .min = 0,
             .max = 0.01});
}

/// Noise of the encoders, and delays.
void declare_lines(Declare<SimulatedDevice>& declaration) {
  using Params = SimulatedDevice::Params;
  declaration
      .real("encoder_noise", &Params::encoder_noise,
            {.doc = "RMS noise of each coordinate before it is rounded; 0 for none",
             .unit = "m",
             .default_value = 0,
             .min = 0,
             .max = 1e-2,
             .in_reference = 0})
      .real("encoder_noise_angle", &Params::encoder_noise_angle,
            {.doc = "the same for its rotation",
             .unit = "rad",
             .default_value = 0,
             .min = 0,
             .max = 0.1,
             .in_reference = 0})
      .integer<std::int32_t>(
          "command_ticks", &Params::command_ticks,
          {.doc = "ticks for which the motors keep a command that is not renewed. After that they have "
                  "zero until the next tick; 0: they keep it for ever",
           .default_value = 2,
           .min = 0,
           .max = 1'000'000})
      .real("delay_in", &Params::delay_in,
            {.doc = "age of the state that the device shows, rounded to whole ticks; 0 or at least half a tick. The "
                    "host does not know it",
             .unit = "s",
             .default_value = 0,
             .min = 0,
             .max = 0.1,
             .in_reference = 0})
      .real("delay_out", &Params::delay_out,
            {.doc = "time until a command reaches the amplifiers, rounded to whole ticks; 0 or at least half a tick",
             .unit = "s",
             .default_value = 0,
             .min = 0,
             .max = 0.1,
             .in_reference = 0});
}

void declare_encoders(Declare<SimulatedDevice>& declaration) {
  using Params = SimulatedDevice::Params;
  declaration
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
             .in_reference = 0});
}

/// What makes a device less than ideal; the defaults leave it off.
void declare_parts(Declare<SimulatedDevice>& declaration) {
  declare_motors(declaration);
  declare_friction(declaration);
  declare_transmission(declaration);
  declare_lines(declaration);
}

}  // namespace

NodeInfo SimulatedDevice::declare() {
  using D = SimulatedDevice;
  Declare<D> declaration("device.simulated", "Simulates a haptic device and the hand on it.");
  declaration
      .details(
          "At each tick it moves the handle, shows its state through encoders and commands the force of the newest "
          "segment, as far as the safety gate lets it through. In open loop, the handle is at the target. In closed "
          "loop, handle and hand are one body, M a = F - b v - friction + b_h (v_T - v) + k_h (x_T - x). The commanded "
          "force, held from tick to tick, drives it, and the hand pulls it towards the target. Rotation works in the "
          "same way. With a grip, the hand is a body of its own, behind a spring and a damper. Mass, damping and "
          "stiffness of the hand default to the usual 0.55 kg, 6.5 N s/m, 135 N/m. A reference run follows the path of "
          "the run under test. The imperfections of a real device are off by default: amplifiers with a bandwidth and "
          "a limit, cogging, breakaway friction, noise of the encoders, delays of the lines, and a transmission with "
          "play and a mode of vibration between the handle and the motor side, where the encoders are. graphs/devices "
          "has overlays that switch them on.")
      .input("target", &D::target, {.doc = "the target pose of the hand"});
  DeviceParams defaults;
  defaults.dead_man_button = 0;
  declare_device(declaration, defaults);
  const auto not_closed = [](const Params& params, const MetricUse&) {
    return std::string(params.loop == Loop::closed ? "" : "loop is open");
  };
  declaration
      .metric(
          "device.energy_generated_J", "J", "most energy that the motors had given to the device, net", Better::lower,
          [](const D& self) { return !self.observes_port() ? std::nullopt : std::optional(self.energy_generated_); })
      .left_out_when(not_closed)
      .metric("device.max_speed_m_per_s", "m/s", "largest speed of the handle", Better::neither,
              [](const D& self) { return !self.observes_port() ? std::nullopt : std::optional(self.max_speed_); })
      .left_out_when(not_closed)
      .metric("device.unkept_path_samples", "1", "ticks beyond those whose path is kept for the reference run",
              Better::lower,
              [](const D& self) {
                return !self.observes_port() ? std::nullopt : std::optional(static_cast<double>(self.unkept_));
              })
      .left_out_when(not_closed);
  declaration
      .metric("device.saturated_ticks", "1",
              "ticks at whose end the motors were at motor_force_max or motor_torque_max", Better::lower,
              [](const D& self) {
                const auto ticks = static_cast<double>(self.saturated_ticks_);
                return self.params_.motor_force_max > 0 || self.params_.motor_torque_max > 0 ? std::optional(ticks)
                                                                                             : std::nullopt;
              })
      .left_out_when([](const Params& params, const MetricUse&) {
        const bool limited = params.motor_force_max > 0 || params.motor_torque_max > 0;
        return std::string(limited ? "" : "the motors have no limit");
      });
  declaration.output("truth", &D::truth, "the true state of the handle")
      .output("motors", &D::motors,
              "the wrench of the motors at the beginning of this tick, after delay_out, amplifier and limits")
      .choice("loop", &Params::loop, {{"open", Loop::open}, {"closed", Loop::closed}}, std::optional(Loop::open),
              "whether the commanded force moves the handle");
  declare_encoders(declaration);
  declare_velocity(declaration);
  declare_line(declaration);
  declare_translation(declaration);
  declare_rotation(declaration);
  declaration.real("sub_step", &Params::sub_step,
                   {.doc = "longest step of the closed loop's integration",
                    .unit = "s",
                    .default_value = 1e-4,
                    .min = 0,
                    .max = 1e-2,
                    .above_min = true});
  declare_parts(declaration);
  return declaration.info();
}

}  // namespace tactor
