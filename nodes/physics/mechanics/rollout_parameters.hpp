// What the nodes of the local rollout declare alike.
#pragma once

#include <string>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "nodes/physics/mechanics/declare_integrator.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

/// The moving bodies as a rollout with these parameters steps them. Throws as scene_model does.
template <class Params>
SystemModel rollout_model(const std::string& type, const Params& params, const NodeContext& context) {
  SystemModel model = scene_model(type, *context.scene, context.notes);
  model.iterations = params.iterations;
  model.stick_velocity = params.stick_velocity;
  model.integrator = params.integrator;
  // A millionth of the force is less than any device shows.
  model.tolerance = 1e-6;
  return model;
}

/// Adds the parameters of the step.
template <class N>
void declare_rollout(Declare<N>& node) {
  using P = typename N::Params;
  node.template integer<std::int32_t>("iterations", &P::iterations,
                                      {.doc = "most Newton iterations in a step; a step that needs more fails",
                                       .default_value = 20,
                                       .min = 8,
                                       .max = 200})
      .real("stick_velocity", &P::stick_velocity,
            {.doc = "sliding speed below which friction is viscous",
             .unit = "m/s",
             .default_value = 1e-4,
             .min = 0,
             .max = 1,
             .above_min = true,
             .as_in = Role::dynamics});
  declare_integrator(node, Role::dynamics);
}

}  // namespace tactor
