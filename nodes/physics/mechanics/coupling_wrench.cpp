#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

Wrench coupling_wrench(const CouplingLaw& law, const PhysicsState& state, bool torque) {
  Wrench device;
  device.force =
      limited(-law.k_t * (state.X_WD.p - state.X_WT.p) - law.b_t * (state.V_WD.v - state.V_WT.v), law.force_max);
  if (torque) {
    const Vec3 turn = to_rotation_vector(state.X_WD.R * inverse(state.X_WT.R));
    device.torque = limited(-law.k_r * turn - law.b_r * (state.V_WD.w - state.V_WT.w), law.torque_max);
  }
  return device;
}

}  // namespace tactor
