#include "nodes/passivity/controller.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tactor {

NodeInfo PassivityController::declare() {
  Declare<PassivityController> node("passivity.controller",
                                    "Damps the handle when its port would give more energy than the hand has given.");
  node.details(
      "Place it between an interpolation and the device. An observer counts the energy that the hand has given through "
      "the handle. At each tick the controller predicts, from the velocity that the device shows, how much of that "
      "energy is left at the next tick and how much the wanted wrench would give then. If the wrench would give more, "
      "a damper along the motion takes off the difference: F - a d, with d the displacement of a tick. The damper "
      "reduces the wrench's part along the motion to zero at most. In debt it goes further to pay the debt back, as "
      "far as a handle of `mass` and `inertia` bears the damping. In debt, only a force against the motion is "
      "commanded. If there is no energy to bring the wrench down to zero at the gate's slew limits, the whole wrench "
      "is scaled down.");
  declare_stage(node);
  return node
      .real("mass", &Params::mass,
            {.doc = "mass of the handle",
             .unit = "kg",
             .default_value = 0.1,
             .min = 0,
             .max = 100,
             .above_min = true,
             .as_in = Role::device})
      .real("inertia", &Params::inertia,
            {.doc = "inertia of the handle",
             .unit = "kg m^2",
             .default_value = 5e-5,
             .min = 0,
             .max = 10,
             .above_min = true,
             .as_in = Role::device})
      .real("damping_share", &Params::damping_share,
            {.doc = "damping that pays back a debt, as a share of mass / tick. A damper that acts a tick late is "
                    "stable below 1",
             .default_value = 0.3,
             .min = 0,
             .max = 0.6})
      .unread_when({"encoder_step", "encoder_step_angle"},
                   [](const Params& p, const ParamUse&) { return std::string(p.rounding > 0 ? "" : "rounding is 0"); })
      .info();
}

PassivityController::PassivityController(const Params& params, const NodeContext& context)
    : PassivityStage(params, context, 0),
      damper_most_(params.damping_share * params.mass * params.rate * params.rate),
      turning_most_(params.damping_share * params.inertia * params.rate * params.rate) {}

Wrench PassivityController::limit(const Wrench& whole) const noexcept {
  const SmallMotion d = way();
  const double lever = params().lever;
  const double length = square(d, lever);
  const double size = std::sqrt(square(whole, lever));
  // What the handle may do meanwhile is foreseen where its state comes late, and else not.
  const Foretold foretold{d};
  const double energy = energy_then(foretold) - farther(foretold, ahead() - 1) * size;
  // No more than can be taken back.
  const double along = size > 0 ? work(whole, d) / size : 0;
  const double ramp = size > 0 ? ramp_down(whole, along) : 0;
  double share = 1;
  if (ramp > energy) {
    // In debt what is against the motion stays as far as it is down to zero before it could give.
    share = std::min(1.0, share_that_takes(whole, along));
    if (energy > 0) share = std::max(share, std::sqrt(energy / ramp));
  }
  const Wrench wanted = share < 1 ? share * whole : whole;
  const double given = work(wanted, d);
  if (energy >= 0 && given <= energy) return wanted;
  if (!(length > 0)) return energy < 0 ? Wrench{} : wanted;
  // The damper's force per m: as much as is needed, as much as the wrench has along the motion, and what is borne.
  if (energy >= 0) {
    const double by = std::min(given - energy, given) / length;
    return {wanted.force - by * d.x, wanted.torque - (by * lever * lever) * d.r};
  }
  const double against = std::max(std::max(0.0, -given / length), std::min(-energy / length, damper_most_));
  return {-against * d.x, -std::min(against * lever * lever, turning_most_) * d.r};
}

}  // namespace tactor
