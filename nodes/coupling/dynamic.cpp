#include "nodes/coupling/dynamic.hpp"

#include "nodes/coupling/declare_coupling.hpp"

namespace tactor {

namespace {

CouplingParameters parameters_for(const DynamicCoupling::Params& params, const CoupledTool& tool) {
  CouplingParameters parameters{.k_t = params.k_t, .force_max = params.force_max, .torque_max = params.torque_max};
  parameters.b_t = damping_of(parameters.k_t, tool.mass, params.zeta);
  if (tool.torque) {
    parameters.k_r = params.k_r;
    parameters.b_r = damping_of(parameters.k_r, tool.inertia, params.zeta);
  }
  return parameters;
}

}  // namespace

DynamicCoupling::DynamicCoupling(const Params& params, const NodeContext& context)
    : DynamicCoupling(params, coupled_tool("coupling.dynamic", context)) {}

DynamicCoupling::DynamicCoupling(const Params& params, const CoupledTool& tool)
    : CouplingNode(parameters_for(params, tool), tool.torque), tool_(tool) {}

void DynamicCoupling::tune(const Params& params) {
  go_to(parameters_for(params, tool_));
}

NodeInfo DynamicCoupling::declare() {
  Declare<DynamicCoupling> d("coupling.dynamic", "A fixed spring with a damper matched to the tool's mass.");
  d.details(
      "F = -k_t (p_WD - p_WT) - b_t (v_WD - v_WT) with b_t = 2 zeta sqrt(k_t m). The torque follows the same equation "
      "with the mean of the tool's principal inertias. The sag m g / k_t of a heavy tool grows with its mass; with "
      "coupling.adaptive it grows less. Source: McNeely, Puterbaugh and Troy, SIGGRAPH 1999.");
  declare_springs(d);
  d.real("zeta", &Params::zeta,
         {.doc = "damping ratio; 1 is critical", .unit = "1", .default_value = 1, .min = 0, .max = 10});
  declare_coupling(d);
  d.tunable({"k_t", "k_r", "zeta", "force_max", "torque_max"});
  return d.info();
}

}  // namespace tactor
