// coupling.dynamic: a fixed spring with a damper matched to the tool's mass.
#pragma once

#include "framework/node/info.hpp"
#include "nodes/coupling/coupling_node.hpp"

namespace tactor {

/// Fixed k_t (N/m) and k_r (N m/rad), b = 2 zeta sqrt(k m) with the mass (kg) and the mean principal inertia (kg m^2)
/// of the scene's tool (W. McNeely, K. Puterbaugh, J. Troy, "Six degree-of-freedom haptic rendering using voxel
/// sampling", SIGGRAPH 1999, section 5). Throws InputError where the tool's mesh has no volume.
class DynamicCoupling final : public CouplingNode {
 public:
  struct Params : CouplingLimits {
    double k_t = 0;
    double k_r = 0;
    double zeta = 0;
  };
  DynamicCoupling(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void tune(const Params& params);

 private:
  DynamicCoupling(const Params& params, const CoupledTool& tool);

  CoupledTool tool_;
};

}  // namespace tactor
