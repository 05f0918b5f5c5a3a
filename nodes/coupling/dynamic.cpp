#include "nodes/coupling/dynamic.hpp"

#include "nodes/coupling/declare_coupling.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

namespace {

CouplingParameters parameters_for(const DynamicCoupling::Params& params, const NodeContext& context) {
  const Body* tool = context.scene->tool();
  if (tool == nullptr) throw InputError("coupling.dynamic needs a moving body in the scene");
  CouplingParameters parameters{.k_t = params.k_t, .force_max = params.force_max, .torque_max = params.torque_max};
  parameters.b_t = damping_of(parameters.k_t, tool->mass, params.zeta);
  if (context.torque) {
    parameters.k_r = params.k_r;
    parameters.b_r = damping_of(parameters.k_r, body_inertia(*tool, context.notes).trace() / 3, params.zeta);
  }
  return parameters;
}

}  // namespace

DynamicCoupling::DynamicCoupling(const Params& params, const NodeContext& context)
    : CouplingNode(parameters_for(params, context), context.torque) {}

NodeInfo DynamicCoupling::declare() {
  Declare<DynamicCoupling> d("coupling.dynamic", "A fixed spring with a damper matched to the tool's mass.");
  d.details(
      "F = -k_t (p_WD - p_WT) - b_t (v_WD - v_WT) with b_t = 2 zeta sqrt(k_t m); the torque likewise with the mean of "
      "the tool's principal inertias. McNeely, Puterbaugh and Troy, SIGGRAPH 1999. The sag m g / k_t of a heavy tool "
      "grows with its mass; coupling.adaptive makes it grow less.");
  d.real("k_t", &Params::k_t,
         {.doc = "stiffness against displacement", .unit = "N/m", .default_value = 500, .min = 0, .above_min = true});
  d.real("k_r", &Params::k_r,
         {.doc = "stiffness against rotation, per rad",
          .unit = "N m/rad",
          .default_value = 1,
          .min = 0,
          .above_min = true});
  d.real("zeta", &Params::zeta,
         {.doc = "damping ratio; 1 is critical", .unit = "1", .default_value = 1, .min = 0, .max = 10});
  declare_coupling(d);
  return d.info();
}

}  // namespace tactor
