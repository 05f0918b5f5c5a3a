// A run that leads a person through an experiment. It is blind: nothing that is shown while it goes on, and nothing
// that is printed at its end, tells which condition was on.
#pragma once

#include <optional>
#include <string>

#include "framework/graph/plan.hpp"

namespace tactor {

/// The node that leads an experiment with a person, by its name: one that sets parameters of others.
std::optional<std::string> experiment_of(const Plan& plan);

}  // namespace tactor
