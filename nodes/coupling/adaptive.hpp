// coupling.adaptive: a spring whose stiffness follows the tool's mass and inertia.
#pragma once

#include "framework/node/info.hpp"
#include "nodes/coupling/coupling_node.hpp"

namespace tactor {

/// k_t = f(m), b_t = g(k_t, m), k_r = d(I), b_r = h(k_r, I) after X. Hou and O. Sourina, "Stable adaptive algorithm for
/// six degrees-of-freedom haptic rendering in a dynamic environment", The Visual Computer 29, 2013. That paper does not
/// print f, g, d and h; these are ours:
///   k_t = clamp(k_0 (m / m_0)^a, k_min, k_device) in N/m,         b_t = 2 zeta sqrt(k_t m) in N s/m,
///   k_r = clamp(k_r0 (I / I_0)^a, k_r_min, k_r_device) in N m/rad, b_r = 2 zeta sqrt(k_r I) in N m s/rad,
/// with I the mean principal inertia (kg m^2). The sag m g / k_t grows as m^(1-a): a = 0 is the fixed spring, a = 1 a
/// sag independent of the mass. Throws InputError where the tool's mesh has no volume or a bound lies above its limit.
class AdaptiveCoupling final : public CouplingNode {
 public:
  struct Params : CouplingLimits {
    double k_0 = 0, m_0 = 0, a = 0, k_min = 0, k_device = 0;
    double k_r0 = 0, I_0 = 0, k_r_min = 0, k_r_device = 0;
    double zeta = 0;
  };
  AdaptiveCoupling(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void tune(const Params& params);

 private:
  AdaptiveCoupling(const Params& params, const CoupledTool& tool);

  CoupledTool tool_;
};

}  // namespace tactor
