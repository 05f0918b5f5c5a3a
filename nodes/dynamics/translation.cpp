#include "nodes/dynamics/translation.hpp"

#include "framework/core/value_error.hpp"
#include "nodes/dynamics/declare_dynamics.hpp"

namespace tactor {

TranslationDynamics::TranslationDynamics(const Params& params, const NodeContext& context)
    : DynamicsNode("dynamics.translation", params, false, context) {
  for (const Body& body : context.scene->bodies) {
    if (body.motion == Motion::rigid) {
      throw ValueError("scene.bodies." + body.name + ".motion",
                       "dynamics.translation: body '" + body.name +
                           "' has motion: rigid; expected motion: translation, or use dynamics.rigid");
    }
  }
}

NodeInfo TranslationDynamics::declare() {
  Declare<TranslationDynamics> d("dynamics.translation",
                                 "Bodies that move without rotating, the tool among them on the coupling spring.");
  d.details(
      "This is dynamics.rigid with 3 degrees of freedom for each body. Use it for a spherical probe, or for any tool "
      "whose orientation does not matter. It computes no rotation and no torque. Every moving body of the scene must "
      "have `motion: translation`.");
  declare_inertial(d);
  d.cheaper("dynamics.quasistatic");
  return d.info();
}

}  // namespace tactor
