// What the declarations of the couplings have in common.
#pragma once

#include <string>

#include "framework/node/declare.hpp"
#include "nodes/coupling/coupling_node.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

/// Adds the ports and the device's limits to the declaration of coupling N.
template <class N>
void declare_coupling(Declare<N>& declaration) {
  using P = typename N::Params;
  // The template arguments let pointers to the members of the base classes convert.
  declaration.realtime_safe()
      .template input<PhysicsState>(
          "state", &N::state,
          {.doc = "tool and handle at one instant; each message gives one force", .trigger = Trigger::yes})
      .template output<Wrench>("force", &N::force, "wrench on the device about its handle, limited by norm")
      .template output<CouplingParameters>("parameters", &N::parameters,
                                           "the spring and damper, sent at the start and when they change")
      .template real<double>("force_max", &P::force_max,
                             {.doc = "largest force on the device, by norm", .unit = "N", .default_value = 8, .min = 0})
      .template real<double>(
          "torque_max", &P::torque_max,
          {.doc = "largest torque on the device, by norm", .unit = "N m", .default_value = 0.3, .min = 0})
      .formerly("parameters", "law")
      .unneeded(nothing_moves)
      .role(Role::coupling);
}

/// Adds the stiffnesses of a coupling that are fixed.
template <class N>
void declare_springs(Declare<N>& declaration) {
  using P = typename N::Params;
  declaration
      .real("k_t", &P::k_t,
            {.doc = "translational stiffness", .unit = "N/m", .default_value = 500, .min = 0, .above_min = true})
      .real(
          "k_r", &P::k_r,
          {.doc = "rotational stiffness, per rad", .unit = "N m/rad", .default_value = 1, .min = 0, .above_min = true});
}

}  // namespace tactor
