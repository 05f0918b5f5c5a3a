#include "nodes/passivity/energy_bound.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/energy_ramp.hpp"

namespace tactor {

NodeInfo EnergyBound::declare() {
  Declare<EnergyBound> node("passivity.energy_bound",
                            "Scales the force down so that a tick cannot give more energy than the hand has given.");
  node.details(
      "Place it between an interpolation and the device. An observer counts the energy E that the hand has given "
      "through the handle. The wrench W wanted at the next tick is scaled by s, the largest 0 <= s <= 1 with s (W . d "
      "+ |W| r) + the energy of the way down to zero at the gate's slew limits <= E - (F . d + |F| q). Here d is the "
      "displacement of the last tick, and F the wrench commanded now. q and r bound how far the displacements of this "
      "tick and the next differ from d if the handle accelerates by at most `acceleration`; they include an encoder "
      "step. If the device's state comes late, wrenches on their way to the device are subtracted like F. So the "
      "commanded energy stays within what is there, whatever a hand within that acceleration does. The wrench is only "
      "scaled; nothing is added to it.");
  declare_stage(node);
  return node
      .real("device_damping", &Params::device_damping,
            {.doc = "viscous friction of the device that the bound relies on: the energy that it takes may be given in "
                    "addition. 0: the motors alone give no net energy",
             .unit = "N s/m",
             .default_value = 0,
             .min = 0,
             .max = 1000})
      .real("bound_share", &Params::bound_share,
            {.doc = "share of the strict bound, max |F| D + max |F . dx| over the ticks so far, that may be given "
                    "before the hand has given it. The bound is what a rounding and a tick can bring in any case",
             .default_value = 0.5,
             .min = 0,
             .max = 1})
      .info();
}

EnergyBound::EnergyBound(const Params& params, const NodeContext& context)
    : PassivityStage(params, context, params.device_damping),
      name_(context.name),
      in_loop_(context.in_loop),
      bound_share_(params.bound_share) {}

void EnergyBound::report(Report& report) const {
  if (most_seen_ahead() <= ahead_foreseen && most_held() <= held_foreseen) return;
  report.remark(
      name_ + ": this run was later than the bound foresees, so it may have given more energy; a command was " +
      "decided on up to " + std::to_string(most_seen_ahead()) + " ticks after the newest state of the device (" +
      std::to_string(ahead_foreseen) + " are foreseen), and stood for up to " + std::to_string(most_held()) +
      " ticks (" + std::to_string(held_foreseen) + " are foreseen); port.energy_generated_J tells what was given");
}

Wrench EnergyBound::limit(const Wrench& wanted) const noexcept {
  const double size = std::sqrt(square(wanted, params().lever));
  if (!(size > 0)) return wanted;
  // By the way of the last tick, since the shown velocity is late. With |acceleration| <= a the way from tick n to n+1
  // differs from it by (n + 1) a T^2 at most, and by (n + 1/2 + k/2) a T^2 from that of a tick in the mean over the
  // last k. A step of the encoder hides as much as its size.
  const Twist& mean = port().mean_velocity();
  const Foretold foretold{{tick() * mean.v, tick() * mean.w},
                          0.5 + 0.5 * port().mean_over() / tick(),
                          std::max(params().encoder_step, params().lever * params().encoder_step_angle)};
  const double energy = std::max(0.0, energy_then(foretold) + bound_share_ * port().strict_bound());
  // m, the most that a tick may go with the wrench.
  const double along = work(wanted, foretold.along) / size + farther(foretold, ahead());
  // A loop may miss a tick, and where states come late one may be missed too: then the wrench is held for two.
  const int ticks = in_loop_ || ahead() > 1 ? held_foreseen : 1;
  const double given = ticks * size * std::max(0.0, along);
  // s given + s^2 ramp <= energy.
  const double ramp = ramp_down(wanted, along);
  const double s = share_within(given, ramp, energy);
  return s < 1 ? s * wanted : wanted;
}

}  // namespace tactor
