// What the stages between an interpolation and a device have in common: ports, the port's energy, what is passed on.
#pragma once

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/passivity/on_its_way.hpp"
#include "nodes/passivity/port_energy.hpp"

namespace tactor {

/// The parameters of every stage; `declare_stage` declares them.
struct StageParams {
  double encoder_step = 0;        ///< m
  double encoder_step_angle = 0;  ///< rad
  double rounding = 0;            ///< share of the worst case
  double start_energy = 0;        ///< J
  double kept_energy = 0;         ///< J
  double stiffness_min = 0;       ///< N/m
  double force_slew = 0;          ///< N/s
  double torque_slew = 0;         ///< N m/s
  double lever = 0;               ///< m
  double acceleration = 0;        ///< m/s^2
  double rate = 0;                ///< Hz
  bool tool_weight = true;        ///< the method displays it
};

/// A stage looks at each tick at the newest segment: the wrench that it has when the device ticks next is what the
/// device is about to command. It goes on to the device unchanged where the port stays passive; else the stage sends a
/// wrench of its own, held from then on. Stamp and trust_time are those of the segment, so that the device's gate sees
/// what is fresh as it does without the stage. A wrench that is not finite goes through, so that the gate faults.
/// Before the device has shown a state, and where nothing has come, nothing is sent.
///
/// The device commands what is sent now at the first tick after now. In a real-time lane of a live run the newest state
/// is a tick old by then, or more: the stage ticks when the device does. What has been sent for the ticks between, and
/// is not shown yet, is charged as if the device commanded it. After `most_ahead` ticks without a state nothing can be
/// said of the energy, and zero is sent. The stage cannot change what the device commands while the stage itself waits
/// for its processor: then its last decision stands.
///
/// A step allocates, locks and waits for nothing, and does the same bounded work each time.
class PassivityStage : public Node {
 public:
  void step(StepContext& context) final;

  Input<ForceSegment> segment;
  Input<DeviceState> device;
  Input<Wrench> commanded;
  Output<ForceSegment> limited;  ///< the port is called `segment` too
  /// Most ticks from the newest state to a command that was decided on, and most ticks for which a decision stood.
  [[nodiscard]] int most_seen_ahead() const { return most_seen_ahead_; }
  [[nodiscard]] std::int64_t most_held() const { return most_held_; }
  /// Of the steps: the share whose wrench was not passed on, and the RMS of what was changed of the force, N.
  [[nodiscard]] double changed_share() const;
  [[nodiscard]] double change_rms() const;
  /// J, of the port, as the stage counts it.
  [[nodiscard]] double least_energy() const { return port_.least(); }

 protected:
  /// `damping` in N s/m, of the device.
  PassivityStage(const StageParams& params, const NodeContext& context, double damping);

  /// What is commanded at the next tick in place of a finite wrench, both without the tool's weight; the same one where
  /// it may be passed on.
  [[nodiscard]] virtual Wrench limit(const Wrench& wanted) const noexcept = 0;

  [[nodiscard]] const PortEnergy& port() const { return port_; }
  /// Of the handle over one tick at the velocity that it is shown to have.
  [[nodiscard]] SmallMotion way() const { return {tick() * port_.velocity().v, tick() * port_.velocity().w}; }
  /// Ticks from the newest state to the command that is decided on: 1 or more.
  [[nodiscard]] int ahead() const { return ahead_; }
  /// How the handle is foretold to go: over each tick the way `along`, in the n-th one after the newest state up to
  /// `beyond` + (n + share) times what the greatest acceleration brings in a tick farther.
  struct Foretold {
    SmallMotion along;
    double share = 0;
    double beyond = 0;  // m
  };
  /// m.
  [[nodiscard]] double farther(const Foretold& foretold, int n) const {
    return foretold.beyond + (n + foretold.share) * params_.acceleration * tick() * tick();
  }
  /// J, that are left when the wrench that is decided on is commanded: the port's energy less what the wrench held now
  /// and those on their way to the device give until then at most.
  [[nodiscard]] double energy_then(const Foretold& foretold) const;
  /// J, that the gate's slew limits give after the tick at which the wrench is commanded, where it comes down to zero
  /// at once and the handle goes `along` m with it in that tick, and goes faster with the greatest acceleration from
  /// then on. That of s times the wrench, 0 <= s <= 1, is s^2 of it at most.
  [[nodiscard]] double ramp_down(const Wrench& wrench, double along) const;
  /// The share of a wrench, above 1 too, of which that way gives nothing: the handle goes against it until it is zero.
  [[nodiscard]] double share_that_takes(const Wrench& wrench, double along) const;
  /// s.
  [[nodiscard]] double tick() const { return tick_.seconds(); }
  [[nodiscard]] const StageParams& params() const { return params_; }

 private:
  [[nodiscard]] Wrench within_energy(const Wrench& wanted) const;
  void send(Time valid, Time from, const ForceSegment& sent);
  /// What the device commands at a tick that it has not shown yet.
  [[nodiscard]] Wrench on_its_way(Time tick) const;

  StageParams params_;
  bool torque_;
  Duration tick_;
  PortEnergy port_;
  OnItsWay<ForceSegment> sent_;
  int ahead_ = 1;
  bool passed_any_ = false;
  bool was_changed_ = false;  // the device has been sent another wrench than was wanted
  std::uint64_t passed_ = 0;  // sequence of the segment that went through last, where `passed_any_`
  std::uint64_t steps_ = 0, changed_ = 0;
  int most_seen_ahead_ = 0;
  Time decided_for_;  // the tick that the last step decided on, where there was one
  std::int64_t most_held_ = 0;
  double change_sum_ = 0;  // N^2
};

/// |a|^2 of a motion, and its like of a wrench, with the lever (m) between way and angle.
inline double square(const SmallMotion& a, double lever) {
  return dot(a.x, a.x) + lever * lever * dot(a.r, a.r);
}
inline double square(const Wrench& a, double lever) {
  return dot(a.force, a.force) + dot(a.torque, a.torque) / (lever * lever);
}

/// Adds what the energy of the port is counted with, and the force bounded.
template <class N>
void declare_budget(Declare<N>& node) {
  using P = typename N::Params;
  const auto real = [&node](const char* name, double StageParams::*member, RealOptions options) {
    node.template real<double>(name, static_cast<double P::*>(member), std::move(options));
  };
  real("encoder_step", &StageParams::encoder_step,
       {.doc = "step of the device's position encoders",
        .unit = "m",
        .default_value = 1e-5,
        .min = 0,
        .max = 1e-2,
        .as_in = Role::device});
  real("encoder_step_angle", &StageParams::encoder_step_angle,
       {.doc = "step of its angle encoders",
        .unit = "rad",
        .default_value = 1e-4,
        .min = 0,
        .max = 0.1,
        .as_in = Role::device});
  real("rounding", &StageParams::rounding,
       {.doc = "share of the encoders' worst rounding that is taken off the energy at each change of the force. 1 is "
               "safe against any rounding, 0 against none",
        .default_value = 0,
        .min = 0,
        .max = 1});
  real("start_energy", &StageParams::start_energy,
       {.doc = "energy that may be given before the hand has given any",
        .unit = "J",
        .default_value = 2e-5,
        .min = 0,
        .max = 1});
  real("kept_energy", &StageParams::kept_energy,
       {.doc = "energy from the hand that may be given back at any force. For comparison: a tool of 0.1 kg has 12.5 mJ "
               "at 0.5 m/s",
        .unit = "J",
        .default_value = 0.02,
        .min = 0,
        .max = 100});
  real("stiffness_min", &StageParams::stiffness_min,
       {.doc = "stiffness of the softest spring that is displayed. At most the energy that this spring holds at the "
               "force, plus kept_energy, is given back of the hand's energy",
        .unit = "N/m",
        .default_value = 50,
        .min = 0,
        .max = 1e6,
        .above_min = true});
  real("force_slew", &StageParams::force_slew,
       {.doc = "fastest change of the force that the device's gate lets through",
        .unit = "N/s",
        .default_value = 2000,
        .min = 0,
        .max = 1e9,
        .above_min = true,
        .as_in = Role::device});
  real("torque_slew", &StageParams::torque_slew,
       {.doc = "fastest change of the torque",
        .unit = "N m/s",
        .default_value = 40,
        .min = 0,
        .max = 1e9,
        .above_min = true,
        .as_in = Role::device});
  real("lever", &StageParams::lever,
       {.doc = "lever arm: an angle counts as the displacement at this distance",
        .unit = "m",
        .default_value = 0.05,
        .min = 0,
        .max = 10,
        .above_min = true});
  real("acceleration", &StageParams::acceleration,
       {.doc = "largest acceleration of the handle that the bound covers. Choose the device's force_max over the mass "
               "of handle and finger, or more if a hand pushes harder than the device",
        .unit = "m/s^2",
        .default_value = 60,
        .min = 0,
        .max = 1e4});
}

/// Adds the ports, parameters and metrics that all stages have.
template <class N>
void declare_stage(Declare<N>& node) {
  using P = typename N::Params;
  const Queue every{QueuePolicy::drop_oldest, 64};
  node.realtime_safe()
      .template input<ForceSegment>("segment", &N::segment,
                                    {.doc = "the force that the interpolation wants", .trigger = Trigger::yes})
      .template input<DeviceState>("device", &N::device, {.doc = "every sample of the handle", .queue = every})
      .template input<Wrench>(
          "commanded", &N::commanded,
          {.doc = "the wrench that the device commands; the energy is counted from it", .queue = every})
      .template output<ForceSegment>("segment", &N::limited, "the same force, or one that keeps the port passive")
      .role(Role::interpolation);
  declare_budget(node);
  node.boolean("tool_weight", static_cast<bool P::*>(&P::tool_weight), true,
               "true if the method displays the tool's weight, whose part of the energy then counts as the hand's own; "
               "false for a proxy and for a force field",
               Role::sink)
      .haptic_rate(static_cast<double P::*>(&P::rate), {.doc = "ticks per second"})
      .metric("passivity.changed_share", "1", "share of the steps whose wrench was not passed on", Better::lower,
              &PassivityStage::changed_share)
      .metric("passivity.change_rms_N", "N", "RMS of what was changed of the force, over all steps", Better::lower,
              &PassivityStage::change_rms)
      .metric("passivity.ahead_most", "1",
              "most ticks from the newest state of the device to the command decided on: 1 under the virtual clock and "
              "in one loop with the device, 2 in a loop of its own; more where something was late",
              Better::lower, &PassivityStage::most_seen_ahead)
      .metric("passivity.held_most", "1",
              "most ticks for which one decision stood: 1 under the virtual clock and in a lane that keeps up; more "
              "where the stage was late",
              Better::lower, &PassivityStage::most_held)
      .metric("passivity.least_energy_J", "J", "least energy of the port, as the stage counts it", Better::higher,
              &PassivityStage::least_energy);
}

}  // namespace tactor
