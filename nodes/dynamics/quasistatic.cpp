#include "nodes/dynamics/quasistatic.hpp"

#include "framework/core/value_error.hpp"
#include "nodes/dynamics/declare_dynamics.hpp"

namespace tactor {

QuasistaticDynamics::QuasistaticDynamics(const Params& params, const NodeContext& context)
    : DynamicsNode("dynamics.quasistatic", {params}, true, context) {
  const std::vector<std::size_t> moving = context.scene->moving();
  if (moving.size() > 1) {
    const std::string& other = context.scene->bodies[moving[1]].name;
    throw ValueError("scene.bodies." + other + ".motion", "dynamics.quasistatic moves the tool alone, and body '" +
                                                              other + "' moves too; use dynamics.rigid");
  }
}

NodeInfo QuasistaticDynamics::declare() {
  Declare<QuasistaticDynamics> d("dynamics.quasistatic",
                                 "A massless tool at the place where the coupling spring and the contacts balance.");
  d.details(
      "k_t (p_WD - p_WT) + sum of contact forces = 0, and the same for torques. The tool has no mass, no weight and no "
      "damper, whatever the coupling and the materials say. Without contact it is where the handle is. Use it with "
      "coupling.static. Nothing smooths the force: the tool jumps when contacts appear and vanish.");
  declare_dynamics(d);
  d.refuses("coupling", "damper",
            "its tool has no damper, and a line of waves pulls the tool by a damper alone; use dynamics.translation");
  return d.info();
}

}  // namespace tactor
