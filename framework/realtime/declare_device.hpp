// What the declarations of the devices have in common.
#pragma once

#include "framework/node/declare.hpp"
#include "framework/realtime/device_node.hpp"

namespace tactor {

/// Adds the parameters of SafetyLimits.
template <class N>
void declare_limits(Declare<N>& declaration, const SafetyLimits& defaults) {
  using P = typename N::Params;
  // The template arguments and casts let pointers to the members of the base classes convert.
  const auto real = [&declaration](const char* name, double SafetyLimits::*member, RealOptions options) {
    options.min = 0;
    declaration.template real<double>(name, static_cast<double P::*>(member), std::move(options));
  };
  real("force_max", &SafetyLimits::force_max,
       {.doc = "largest force, by norm", .unit = "N", .default_value = defaults.force_max, .max = 1000});
  real("torque_max", &SafetyLimits::torque_max,
       {.doc = "largest torque, by norm", .unit = "N m", .default_value = defaults.torque_max, .max = 100});
  declaration.tunable({"force_max", "torque_max"});
  real("force_slew", &SafetyLimits::force_slew,
       {.doc = "fastest change of the force. 2000 N/s is more than twice what a held physics force needs in the graphs "
               "of this project (0.84 N in a millisecond)",
        .unit = "N/s",
        .default_value = defaults.force_slew,
        .max = 1e9,
        .above_min = true});
  real("torque_slew", &SafetyLimits::torque_slew,
       {.doc = "fastest change of the torque. 40 N m/s is more than three times what a held physics torque needs in "
               "the graphs of this project (0.012 N m in a millisecond)",
        .unit = "N m/s",
        .default_value = defaults.torque_slew,
        .max = 1e9,
        .above_min = true});
  real("speed_max", &SafetyLimits::speed_max,
       {.doc = "a faster handle is braked, and then gets no force",
        .unit = "m/s",
        .default_value = defaults.speed_max,
        .max = 100,
        .above_min = true});
  real("angular_speed_max", &SafetyLimits::angular_speed_max,
       {.doc = "a handle that turns faster is braked, and then gets no force",
        .unit = "rad/s",
        .default_value = defaults.angular_speed_max,
        .max = 1000,
        .above_min = true});
}

/// Adds the metrics of the safety gate.
template <class N>
void declare_gate_metrics(Declare<N>& declaration) {
  const auto count = [&declaration](const std::string& name, const std::string& doc, const auto& value) {
    declaration.metric("device." + name, "1", doc, Better::lower, value);
  };
  count("rejected_forces", "ticks whose wrench was not finite",
        [](const DeviceNode& self) { return self.gate().account().rejected; });
  count("rejected_segments", "messages that were not fresh segments", &DeviceNode::rejected_segments);
  count("faults", "times that the safety gate went into fault",
        [](const DeviceNode& self) { return self.gate().account().faults; });
  count("stale", "times that no fresh segment came in time",
        [](const DeviceNode& self) { return self.gate().count(SafetyCause::stale); });
  count("clamped_ticks", "ticks whose wrench was beyond force_max or torque_max",
        [](const DeviceNode& self) { return self.gate().account().clamped; });
  count("slewed_ticks", "ticks whose wrench changed faster than force_slew or torque_slew",
        [](const DeviceNode& self) { return self.gate().account().slewed; });
  declaration.metric("device.engaged_share", "1", "share of the ticks at which the gate was engaged", Better::higher,
                     [](const DeviceNode& self) {
                       const auto ticks = static_cast<double>(self.gate().account().ticks);
                       return ticks > 0 ? static_cast<double>(self.gate().account().engaged) / ticks : 0.0;
                     });
  declaration.metric(
      "device.expired_per_min", "1",
      "ticks in a minute that found that the device had let go of the command before, because it was not "
      "renewed in time",
      Better::lower, [](const DeviceNode& self) {
        const GateAccount& account = self.gate().account();
        const auto expired = account.present[static_cast<std::size_t>(SafetyCause::expired)];
        const double minutes = static_cast<double>(account.ticks) * self.gate().longest_tick().seconds() / 2 / 60;
        return minutes > 0 ? static_cast<double>(expired) / minutes : 0.0;
      });
  for (const SafetyCause cause : reported_causes) {
    const std::string name(name_of(cause));
    count("causes." + name, "times that the cause " + name + " came up", [cause](const DeviceNode& self) {
      const auto times = static_cast<double>(self.gate().count(cause));
      return times > 0 ? std::optional(times) : std::nullopt;
    });
    declaration.missing_where("it never came up");
  }
}

/// Adds the ports and metrics of DeviceNode and the parameters of DeviceParams to the declaration of device N, whose
/// Params derive from it; `defaults` are those of the device. Marks N as an actuator.
template <class N>
void declare_device(Declare<N>& declaration, const DeviceParams& defaults = {}) {
  using P = typename N::Params;
  const auto time = [&declaration](const char* name, Duration P::*member, const char* doc, Duration default_value,
                                   double least, double most) {
    declaration.template real<Duration>(
        name, member, {.doc = doc, .unit = "s", .default_value = default_value.seconds(), .min = least, .max = most});
  };
  declaration.actuator()
      .template input<ForceSegment>(
          "segment", &N::segment,
          {.doc = "the force to command, evaluated each tick", .required = false, .in_reference = false})
      .template output<DeviceState>("state", &N::state, "the state of the handle as the device shows it")
      .template output<Wrench>("interpolated", &N::interpolated, "the segment at this tick, before the safety gate")
      .template output<Wrench>("commanded", &N::commanded, "the wrench on the handle, after the safety gate")
      .template output<SafetyState>("safety", &N::safety, "what the safety gate did at this tick")
      .haptic_rate(static_cast<double P::*>(&P::rate), {.doc = "ticks per second", .in_reference = 10000});
  declare_limits(declaration, defaults);
  time("engage_time", static_cast<Duration P::*>(&P::engage_time), "duration of the ramp from zero to the full wrench",
       defaults.engage_time, 1e-3, 10);
  time("stale_after", static_cast<Duration P::*>(&P::stale_after),
       "the wrench ramps to zero after this time without a fresh segment, or sooner if a segment states a shorter "
       "trust_time. Choose more than physics takes for a result",
       defaults.stale_after, 1e-3, 10);
  time("ramp_down_time", static_cast<Duration P::*>(&P::ramp_down_time),
       "duration of the ramp to zero. With stale_after it bounds how long a force outlives its pipeline",
       defaults.ramp_down_time, 1e-3, 10);
  time("brake_time", static_cast<Duration P::*>(&P::brake_time), "the longest brake of a handle that is too fast",
       defaults.brake_time, 0, 1);
  time("recovery_time", static_cast<Duration P::*>(&P::recovery_time),
       "time for which the inputs must have been healthy after a fault before force returns", defaults.recovery_time, 0,
       60);
  time("failure_timeout", static_cast<Duration P::*>(&P::failure_timeout),
       "the run ends after the device could not be read or written for this time", defaults.failure_timeout, 0, 60);
  time("sample_age_max", static_cast<Duration P::*>(&P::sample_age_max),
       "a force made from an older sample of the device does not count as fresh. Choose several times the longest step "
       "of the physics",
       defaults.sample_age_max, 1e-3, 60);
  declaration.template integer<std::int32_t>(
      "dead_man_button", static_cast<std::optional<std::int32_t> P::*>(&P::dead_man_button),
      "the first, where there is one",
      {.doc = "the button that must be held to get a force; 1: the first button, 0: none",
       .default_value = defaults.dead_man_button,
       .min = 0,
       .max = 31});
  declaration.means("dead_man_button", ParamMeaning::dead_man_button);
  declare_gate_metrics(declaration);
}

}  // namespace tactor
