// The parameter that chooses how a step of rigid bodies goes from its start to its end.
#pragma once

#include <optional>

#include "framework/node/declare.hpp"
#include "nodes/physics/mechanics/system.hpp"

namespace tactor {

/// Adds the parameter `integrator`. `as_in`: the role of the node whose value it has where a graph gives none.
template <class N>
void declare_integrator(Declare<N>& node, std::optional<Role> as_in = std::nullopt) {
  node.template choice<Integrator>("integrator", &N::Params::integrator,
                                   {{"implicit_euler", Integrator::implicit_euler}, {"midpoint", Integrator::midpoint}},
                                   Integrator::implicit_euler,
                                   "implicit_euler is of first order and damps fast motion; midpoint is of second "
                                   "order, and springs keep their energy",
                                   std::nullopt, as_in);
}

}  // namespace tactor
