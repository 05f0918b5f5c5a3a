// What the declarations of the kinds of dynamics have in common.
#pragma once

#include <string>

#include "framework/node/declare.hpp"
#include "nodes/dynamics/dynamics_node.hpp"
#include "nodes/physics/mechanics/declare_integrator.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

/// Adds the ports, the parameters and the metrics that all kinds have to the declaration of dynamics N. `substep`: the
/// default of the longest sub-step, s.
template <class N>
void declare_moving(Declare<N>& declaration, double substep) {
  using P = typename N::Params;
  using AdvanceTo = DynamicsParams::AdvanceTo;
  // The template arguments let pointers to the members of the base classes convert.
  declaration.on_thread("physics")
      .template input<ContactSet>(
          "contacts", &N::contacts,
          {.doc = "contact planes of the last query", .trigger = Trigger::yes, .required = false})
      .template input<DeviceState>("device", &N::device,
                                   {.doc = "every sample of the handle",
                                    .trigger = Trigger::when_alone,
                                    .queue = {QueuePolicy::drop_oldest, 4096}})
      .template input<CouplingParameters>("coupling", &N::coupling,
                                          {.doc = "the spring and damper between handle and tool"})
      .formerly("coupling", "law")
      .template output<PhysicsState>("state", &N::state, "tool and handle at the time of the last sample used")
      .template output<BodyStates>("bodies", &N::bodies, "all moving bodies at that time, the tool first")
      .template output<LocalPatch>("patch", &N::patch,
                                   "the deformable surface around the tool, condensed onto a few nodes. It is empty if "
                                   "nothing deforms, and computed only if something reads it")
      .template output<BodyStates>("expected", &N::expected,
                                   "the moving bodies at the time of the newest handle sample, reached in a few steps, "
                                   "for the next contact query. They are computed only if something reads them")
      .template real<double>(
          "substep", &P::substep,
          {.doc = "longest sub-step", .unit = "s", .default_value = substep, .min = 1e-6, .max = 0.1})
      .template integer<std::int32_t>(
          "iterations", &P::iterations,
          {.doc = "most Newton iterations in a sub-step. If they do not suffice, a damped step is taken and counted",
           .default_value = 60,
           .min = 1,
           .max = 200})
      .template real<double>("stick_velocity", &P::stick_velocity,
                             {.doc = "sliding speed below which friction is viscous",
                              .unit = "m/s",
                              .default_value = 1e-4,
                              .min = 0,
                              .max = 1,
                              .above_min = true})
      .template choice<AdvanceTo>("advance_to", &P::advance_to,
                                  {{"contacts", AdvanceTo::contacts}, {"now", AdvanceTo::now}},
                                  std::optional(AdvanceTo::contacts),
                                  "how far to simulate: to the time the contact query began, or to the newest sample")
      .boolean("start_at_device", &P::start_at_device, true,
               "start the tool at the handle's first pose, so that the spring is slack")
      .coarser("substep", {2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2})
      .coarser("iterations", {std::int64_t{20}, std::int64_t{10}, std::int64_t{5}})
      .unneeded(nothing_moves)
      .role(Role::dynamics)
      .scene_law();
  declaration
      .metric("dynamics_steps", "1", "sub-steps", Better::neither, [](const N& self) { return self.counts().steps; })
      .summed()
      .metric("dynamics_damped_steps", "1", "sub-steps that Newton's method did not solve: a damped step was taken",
              Better::lower, [](const N& self) { return self.counts().damped; })
      .summed()
      .metric("dynamics_stopped_steps", "1", "sub-steps that nothing solved: the bodies were stopped", Better::lower,
              [](const N& self) { return self.counts().stopped; })
      .summed()
      .metric("dynamics_contacts_left_out", "1", "contacts that could not be used", Better::lower,
              [](const N& self) { return self.counts().left_out; })
      .summed()
      .metric("dynamics_rejected_samples", "1", "samples of the handle that were not finite", Better::lower,
              [](const N& self) { return self.refusals().refused(); })
      .summed();
}

/// The same, with the metrics of the energy that rigid bodies make and lose.
template <class N>
void declare_dynamics(Declare<N>& declaration) {
  declare_moving(declaration, 0.001);
  declaration
      .metric("dynamics_energy_generated_J", "J", "energy that steps and new contacts made out of nothing",
              Better::lower, [](const N& self) { return self.observer().generated(); })
      .metric("dynamics_energy_generated_max_J", "J", "most energy that one step or new contact made out of nothing",
              Better::lower, [](const N& self) { return self.observer().largest(); })
      .metric("dynamics_energy_dissipated_J", "J", "energy that the steps dissipated", Better::neither,
              [](const N& self) { return self.observer().dissipated(); })
      .metric("dynamics_energy_taken_J", "J", "energy that `dissipate_above` took out of the velocities",
              Better::neither, [](const N& self) { return self.observer().taken(); });
}

/// Adds the parameters and metrics of the kinds whose bodies all have mass.
template <class N>
void declare_inertial(Declare<N>& declaration) {
  using P = typename N::Params;
  declare_dynamics(declaration);
  declaration
      .refuses("coupling", "massless",
               "it needs a tool with mass, and that coupling has a massless tool; use dynamics.quasistatic, or a "
               "coupling with a damper")
      .boolean("error_estimate", &P::error_estimate, false,
               "compare each sub-step with two half steps and report the position error of the tool. The run takes "
               "three times as long")
      .template real<double>("substep_tolerance", &P::substep_tolerance,
                             {.doc = "a sub-step with a larger position error is shortened; 0: the sub-step is fixed",
                              .unit = "m",
                              .default_value = 0,
                              .min = 0,
                              .max = 0.01})
      .template real<double>("min_substep", &P::min_substep,
                             {.doc = "shortest sub-step if `substep_tolerance` is set",
                              .unit = "s",
                              .default_value = 5e-5,
                              .min = 1e-6,
                              .max = 0.02})
      .template real<double>("dissipate_above", &P::dissipate_above,
                             {.doc = "limit on the energy that steps and new contact sets have generated and that has "
                                     "not been dissipated since. Energy above it is taken out of the velocities, but "
                                     "this much kinetic energy is always left. 1 MJ: nothing is taken",
                              .unit = "J",
                              .default_value = 0.001,
                              .min = 0,
                              .max = 1e6});
  declare_integrator(declaration);
  declaration.coarser("error_estimate", {false}).coarser("substep_tolerance", {1e-7, 1e-6, 1e-5, 1e-4});
  const auto not_estimated = [](const P& params, const MetricUse&) {
    const bool is_estimated = params.error_estimate || params.substep_tolerance > 0;
    return std::string(is_estimated ? "" : "error_estimate is false and substep_tolerance is 0");
  };
  declaration
      .metric("dynamics_position_error_max_m", "m",
              "largest position error of the tool that a sample of the handle adds, estimated", Better::lower,
              &DynamicsNode::position_error_max)
      .left_out_when(not_estimated)
      .metric("dynamics_position_error_mean_m", "m",
              "mean position error of the tool that a sample of the handle adds, estimated", Better::lower,
              &DynamicsNode::position_error_mean)
      .left_out_when(not_estimated);
}

}  // namespace tactor
