// dynamics.auto: the dynamics that suit a scene.
#pragma once

#include "framework/node/info.hpp"

namespace tactor {

/// A type that stands for another: dynamics.deformable where a body deforms, dynamics.translation where none rotates,
/// dynamics.rigid else. What all of them have is passed on.
struct AutoDynamics {
  static NodeInfo declare();
  static Resolution choose(const Scene& scene);
};

}  // namespace tactor
