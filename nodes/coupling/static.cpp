#include "nodes/coupling/static.hpp"

#include "nodes/coupling/declare_coupling.hpp"

namespace tactor {

StaticCoupling::StaticCoupling(const Params& params, const NodeContext& context)
    : CouplingNode({.k_t = params.k_t,
                    .k_r = context.torque ? params.k_r : 0,
                    .force_max = params.force_max,
                    .torque_max = params.torque_max,
                    .massless = 1},
                   context.torque) {}

NodeInfo StaticCoupling::declare() {
  Declare<StaticCoupling> d("coupling.static", "A spring between the handle and a massless tool in balance.");
  d.details(
      "F = -k_t (p_WD - p_WT), torque = -k_r log(R_WD R_WT^T). The tool has neither inertia nor weight: it goes where "
      "the spring and the contacts balance. Without damper it is the simplest coupling and the noisiest.");
  d.real("k_t", &Params::k_t,
         {.doc = "stiffness against displacement", .unit = "N/m", .default_value = 500, .min = 0, .above_min = true});
  d.real("k_r", &Params::k_r,
         {.doc = "stiffness against rotation, per rad",
          .unit = "N m/rad",
          .default_value = 1,
          .min = 0,
          .above_min = true});
  declare_coupling(d);
  d.kind("parameters", "massless");
  return d.info();
}

}  // namespace tactor
