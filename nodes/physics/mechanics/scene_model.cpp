#include "nodes/physics/mechanics/scene_model.hpp"

#include "framework/core/check.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

SystemModel scene_model(const std::string& type, const Scene& scene, Notes* notes) {
  SystemModel model;
  model.count = 0;
  for (const std::size_t i : scene.moving()) {
    const Body& body = scene.bodies[i];
    BodyModel& m = model.body[static_cast<std::size_t>(model.count++)];
    m.mass = body.mass;
    m.rotates = body.motion == Motion::rigid;
    if (m.rotates) m.inertia_B = body_inertia(body, notes);
  }
  if (model.count == 0) throw InputError(type + " needs a moving body in the scene");
  model.gravity_W = scene.gravity_W;
  return model;
}

void refuse_deformable(const Scene& scene, const std::string& does, const std::string& use) {
  const std::vector<std::size_t> soft = scene.deformable();
  if (soft.empty()) return;
  const std::string& name = scene.bodies[soft.front()].name;
  throw ValueError("scene.bodies." + name + ".motion",
                   does + " rigid bodies, and body '" + name + "' deforms; use " + use);
}

}  // namespace tactor
