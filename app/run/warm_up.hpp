// When the nodes of a run are warm, from the cache, or found and put there.
#pragma once

#include "app/run/references.hpp"
#include "framework/engine/warmth.hpp"

namespace tactor {

/// As find_warmth has it of a plan whose clock is virtual. Trouble with keeping it is noted.
Warmth cached_warmth(const Plan& plan, const ReferenceOptions& options);

}  // namespace tactor
