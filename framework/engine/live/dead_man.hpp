// Hardware needs a button that stops the force when a person lets go, or somebody who does without one.
#pragma once

#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// Asks once where nodes of hardware have no dead-man button and their graph does not do without one (`dead_man_button:
/// 0`). Throws YamlError with the place of each such node where the answer is no, or `ask` is null. Notes of the other
/// ones which button a person must hold, or that the graph does without.
void check_dead_man(PlanNodes& nodes, const Ask& ask);

}  // namespace tactor
