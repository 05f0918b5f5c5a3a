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
  // Another body, fixed or moving as a whole, can be hit.
  if (scene.bodies.size() - scene.deformable().size() > 1) return {};
  return scene.bodies.size() > 1
             ? "only deformable bodies can be hit, and dynamics.deformable finds those contacts itself"
             : "the scene has nothing to hit";
}

}  // namespace tactor
