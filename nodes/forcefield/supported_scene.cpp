#include "nodes/forcefield/supported_scene.hpp"

#include "framework/core/check.hpp"

namespace tactor {

void check_static_scene(std::string_view type, const Scene& scene) {
  const std::string name(type);
  const std::string instead =
      "; expected a fixed scene and one body with motion: translation, or use a prediction.* "
      "and an interpolation.* in its place";
  const std::vector<std::size_t> moving = scene.moving();
  if (moving.empty()) throw InputError(name + ": nothing in the scene moves" + instead);
  if (moving.size() > 1) {
    throw InputError(name + ": the force is looked up by the handle's position, and body '" +
                     scene.bodies[moving[1]].name + "' moves besides the tool" + instead);
  }
  if (scene.rotates()) {
    throw InputError(name + ": the force is looked up by the handle's position, and the tool '" + scene.tool()->name +
                     "' rotates" + instead);
  }
  if (const std::vector<std::size_t> soft = scene.deformable(); !soft.empty()) {
    throw InputError(name + ": the force is looked up by the handle's position, and body '" +
                     scene.bodies[soft.front()].name + "' deforms" + instead);
  }
  if (scene.bodies.size() == 1) throw InputError(name + ": the scene has nothing to hit" + instead);
}

}  // namespace tactor
