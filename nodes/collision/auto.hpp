// collision.auto: the collision that suits a scene.
#pragma once

#include "framework/node/info.hpp"

namespace tactor {

/// A type that stands for another: collision.none where nothing can touch, collision.primitive where no mesh moves,
/// collision.sdf else. What all of them have is passed on: margin, spacing, max_contacts.
struct AutoCollision {
  static NodeInfo declare();
  static Resolution choose(const Scene& scene);
};

}  // namespace tactor
