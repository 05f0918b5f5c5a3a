#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

bool is_usable(const CouplingParameters& c) {
  constexpr double largest = 1e12;
  // A comparison with NaN is false.
  const auto fits = [](double x) { return x >= 0 && x <= largest; };
  return fits(c.k_t) && fits(c.b_t) && fits(c.k_r) && fits(c.b_r) && c.force_max >= 0 && c.torque_max >= 0;
}

Wrench coupling_wrench(const CouplingParameters& coupling, const PhysicsState& state, bool torque) {
  Wrench device;
  device.force = limited(-coupling.k_t * (state.X_WD.p - state.X_WT.p) - coupling.b_t * (state.V_WD.v - state.V_WT.v),
                         coupling.force_max);
  if (torque) {
    const Vec3 turn = to_rotation_vector(state.X_WD.R * inverse(state.X_WT.R));
    device.torque = limited(-coupling.k_r * turn - coupling.b_r * (state.V_WD.w - state.V_WT.w), coupling.torque_max);
  }
  return device;
}

}  // namespace tactor
