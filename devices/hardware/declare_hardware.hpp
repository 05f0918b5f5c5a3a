// What the declarations of devices of hardware have in common.
#pragma once

#include <algorithm>
#include <span>

#include "devices/hardware/hardware_device.hpp"
#include "devices/hardware/status_info.hpp"
#include "framework/realtime/declare_device.hpp"
#include "framework/realtime/declare_velocity.hpp"

namespace tactor {

/// What hardware may give a hand by default, at most.
inline constexpr double careful_force = 3;     // N
inline constexpr double careful_torque = 0.1;  // N m

/// Adds the ports of DeviceNode, the parameters of HardwareParams and the metrics of HardwareDevice to the declaration
/// of device N; `defaults` are those of the device. By default the force is at most `careful_force`, the torque at most
/// `careful_torque`, and the device's first button is the dead-man button. Marks N as hardware.
template <class N>
void declare_hardware(Declare<N>& declaration, HardwareParams defaults = {}) {
  using P = typename N::Params;
  defaults.force_max = std::min(defaults.force_max, careful_force);
  defaults.torque_max = std::min(defaults.torque_max, careful_torque);
  declare_device(declaration, defaults);
  const auto time = [&](const char* name, Duration P::*member, const char* doc, Duration value, double min,
                        double max) {
    declaration.real(name, member, {.doc = doc, .unit = "s", .default_value = value.seconds(), .min = min, .max = max});
  };
  declaration.hardware();
  time("link_timeout", static_cast<Duration P::*>(&P::link_timeout),
       "age of a sample at which the device counts as failed", defaults.link_timeout, 1e-3, 10);
  time("connect_timeout", static_cast<Duration P::*>(&P::connect_timeout),
       "the device fails after this time without a first sample; after 1 s already if no attempt to open the line "
       "succeeds",
       defaults.connect_timeout, 0.1, 600);
  time("stuck_after", static_cast<Duration P::*>(&P::stuck_after),
       "an encoder counts as stuck if it shows no change for this time under a fifth of the largest force; 0: never",
       defaults.stuck_after, 0, 600);
  declaration
      .choice(
          "guard", static_cast<GuardChoice P::*>(&P::guard),
          {{"auto", GuardChoice::automatic}, {"on", GuardChoice::on}, {"off", GuardChoice::off}},
          std::optional(defaults.guard),
          "whether the line runs in a process of its own, tactor-guard, which takes the force to zero within 5 ms if "
          "this program dies or stops; auto: unless the device has a watchdog of its own below 100 ms")
      .real("workspace_scale", static_cast<double P::*>(&P::workspace_scale),
            {.doc = "motion in the scene per motion of the device",
             .default_value = defaults.workspace_scale,
             .min = 0,
             .max = 1e4,
             .above_min = true})
      .real("force_scale", static_cast<double P::*>(&P::force_scale),
            {.doc = "force at the device per force in the scene. If it equals workspace_scale, power is preserved",
             .default_value = defaults.force_scale,
             .min = 0,
             .max = 1e4,
             .above_min = true})
      .reals("rotation", static_cast<std::vector<double> P::*>(&P::rotation), 3, defaults.rotation,
             {.doc = "rotation vector of the device's base in the scene", .unit = "rad", .min = -7, .max = 7})
      .reals("origin", static_cast<std::vector<double> P::*>(&P::origin), 3, defaults.origin,
             {.doc = "position of the device's zero in the scene", .unit = "m", .min = -1e3, .max = 1e3});
  declare_velocity(declaration);
  declare_line(declaration);
  const auto count = [&declaration](const std::string& name, const std::string& doc, Better better) {
    declaration.metric("device." + name, "1", doc, better);
  };
  count("link.cycles", "cycles of the line", Better::neither);
  count("link.reconnects", "times that the line was opened anew", Better::lower);
  count("link.skipped", "cycles that were skipped because an earlier one took too long", Better::lower);
  for (int i = 1; i < link_error_count; ++i) {
    const std::string error(name_of(static_cast<LinkError>(i)));
    count("link.errors." + error, "failures of the line: " + error, Better::lower);
  }
  const auto latency = [&declaration](const std::string& name, const std::string& of, const char* missing) {
    for (const auto& [end, which] : {std::pair{"p50", "median"}, {"p99", "99th percentile"}, {"max", "largest"}}) {
      declaration.metric("device.link." + name + "." + end, "us", of + ", " + which, Better::lower)
          .missing_where(missing);
    }
  };
  count(
      "link.expired",
      "cycles of the line that gave the device zero because the loop had not renewed its command for two cycles of the "
      "slower of loop and line",
      Better::lower);
  latency("age_us", "age of the sample in use at a tick", "no sample comes");
  latency("cycle_us", "time of a cycle of the line", "no cycle ends");
  count("jumps", "samples in which an encoder jumped, which are not believed", Better::lower);
  count("stuck", "times that an encoder stood still under a force", Better::lower);
  count("limited_ticks", "cycles of the line whose efforts were shortened to the device's own limits", Better::lower);
  declaration.metric(
      "device.velocity_cutoff_Hz", "Hz",
      "of the filters that estimate the handle's velocity, the cutoff of the one of order 3 that expects "
      "`velocity_departure`; the calmest of order 3 has 0.63 of it",
      Better::neither);
}

/// For devices with a gripper: its ports.
template <class N>
void declare_gripper(Declare<N>& declaration) {
  declaration
      .template input<GripperForce>("gripper_force", &N::gripper_force,
                                    {.doc = "what its motor is to give; as far as the safety gate is open",
                                     .required = false,
                                     .in_reference = false})
      .template output<GripperState>("gripper", &N::gripper, "how far the gripper is open");
}

/// For devices that tell more of themselves, in the order of LinkSample::status: a port, and for each value two
/// metrics, device.status.NAME and device.status.NAME.most.
template <class N>
void declare_status(Declare<N>& declaration, std::span<const StatusInfo> values) {
  TACTOR_DEMAND(!values.empty() && values.size() <= max_status);
  std::string names;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const StatusInfo& info = values[i];
    names += (i == 0 ? "" : ", ") + info.name + (info.unit == "1" ? "" : " (" + info.unit + ")");
    const std::string metric = "device.status." + info.name;
    declaration
        .metric(metric, info.unit, info.doc + ", at the end", Better::neither,
                [i](const HardwareDevice& self) { return self.newest_status(i); })
        .missing_where("no sample comes")
        .metric(metric + ".most", info.unit, info.doc + ", largest", Better::neither,
                [i](const HardwareDevice& self) { return self.most_status(i); })
        .missing_where("no sample comes");
  }
  declaration.template output<HardwareStatus>("status", &N::status, "when it changes: " + names);
}

}  // namespace tactor
