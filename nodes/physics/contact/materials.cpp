#include "nodes/physics/contact/materials.hpp"

#include <cmath>

namespace tactor {

Material combine(const Material& a, const Material& b) {
  Material both = a.stiffness <= b.stiffness ? a : b;
  const double sum = a.stiffness + b.stiffness;
  both.stiffness = sum > 0 ? a.stiffness * (b.stiffness / sum) : 0;
  both.friction = std::sqrt(a.friction * b.friction);
  return both;
}

std::string nothing_to_hit(const Scene& scene) {
  if (scene.tool() == nullptr) return "nothing in the scene moves";
  // Another body, fixed or moving, can be hit.
  return scene.bodies.size() > 1 ? std::string() : "the scene has nothing to hit";
}

}  // namespace tactor
