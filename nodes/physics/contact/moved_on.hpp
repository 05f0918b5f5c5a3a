// Bodies that keep their velocities for a while.
#pragma once

#include "framework/core/messages.hpp"

namespace tactor {

/// Where the bodies are `time` s later if they keep their velocities.
inline BodyStates moved_on(const BodyStates& bodies, double time) {
  BodyStates later = bodies;
  for (std::size_t i = 0; i < static_cast<std::size_t>(bodies.count); ++i) {
    later.X_WB[i].p += time * bodies.V_WB[i].v;
    later.X_WB[i].R = from_rotation_vector(time * bodies.V_WB[i].w) * later.X_WB[i].R;
  }
  return later;
}

}  // namespace tactor
