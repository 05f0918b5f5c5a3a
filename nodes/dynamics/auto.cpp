#include "nodes/dynamics/auto.hpp"

#include "nodes/dynamics/declare_dynamics.hpp"
#include "nodes/dynamics/deformable.hpp"
#include "nodes/dynamics/rigid.hpp"
#include "nodes/dynamics/translation.hpp"

namespace tactor {

Resolution AutoDynamics::choose(const Scene& scene) {
  static const NodeInfo deformable = DeformableDynamics::declare();
  static const NodeInfo translation = TranslationDynamics::declare();
  static const NodeInfo rigid = RigidDynamics::declare();
  if (const std::vector<std::size_t> soft = scene.deformable(); !soft.empty()) {
    return {&deformable, "the body " + scene.bodies[soft.front()].name + " deforms"};
  }
  for (const std::size_t i : scene.moving()) {
    const Body& body = scene.bodies[i];
    if (body.motion == Motion::rigid) return {&rigid, "the body " + body.name + " rotates"};
  }
  return {&translation, "no body rotates"};
}

NodeInfo AutoDynamics::declare() {
  // The ports and parameters that all have.
  Declare<TranslationDynamics> d("dynamics.auto",
                                 "The dynamics that suit the scene: deformable, rigid or translation.");
  d.details(
      "It takes dynamics.deformable if a body deforms, dynamics.translation if no body rotates, and dynamics.rigid "
      "otherwise. `tactor check --explain` and the summary of a run name the choice and its reason.");
  declare_moving(d, 0.001);
  NodeInfo info = d.info();
  // Each kind has a default of its own.
  std::erase_if(info.params, [](const ParamInfo& param) { return param.name == "substep"; });
  info.nature = StandIn{choose};
  return info;
}

}  // namespace tactor
