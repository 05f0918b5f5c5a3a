#include "nodes/coupling/static.hpp"

#include "nodes/coupling/declare_coupling.hpp"

namespace tactor {

namespace {

CouplingParameters parameters_for(const StaticCoupling::Params& params, bool torque) {
  return {.k_t = params.k_t,
          .k_r = torque ? params.k_r : 0,
          .force_max = params.force_max,
          .torque_max = params.torque_max,
          .massless = 1};
}

}  // namespace

StaticCoupling::StaticCoupling(const Params& params, const NodeContext& context)
    : CouplingNode(parameters_for(params, context.torque), context.torque), torque_(context.torque) {}

void StaticCoupling::tune(const Params& params) {
  go_to(parameters_for(params, torque_));
}

NodeInfo StaticCoupling::declare() {
  Declare<StaticCoupling> d("coupling.static", "A spring between the handle and a massless tool in balance.");
  d.details(
      "F = -k_t (p_WD - p_WT), torque = -k_r log(R_WD R_WT^T). The tool has neither inertia nor weight: it goes where "
      "the spring and the contacts balance. It has no damper, which makes it the simplest and the noisiest coupling.");
  declare_springs(d);
  declare_coupling(d);
  d.tunable({"k_t", "k_r", "force_max", "torque_max"});
  d.kind("parameters", "massless");
  return d.info();
}

}  // namespace tactor
