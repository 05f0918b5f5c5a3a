// The energy of the bodies, the coupling's spring and the contacts, and the work of the handle.
#pragma once

#include "nodes/physics/mechanics/system.hpp"

namespace tactor {

/// J.
struct Energy {
  double kinetic = 0;
  double gravity = 0;  ///< - sum m g . p, zero at the world's origin
  double spring = 0;   ///< k_t |p_WD - p_WT|^2 / 2 + k_r |log(R_WD R_WT^T)|^2 / 2
  /// Sum of (k d^2 + m_c (n . u)^2) / 2 over the planes that overlap by d, with k = stiffness * weight, m_c = inertia *
  /// weight and u the relative velocity at the contact point.
  double contact = 0;
  [[nodiscard]] double total() const { return kinetic + gravity + spring + contact; }
};

/// With coupling.massless the tool has neither kinetic energy nor weight, nor contacts inertia. Planes that are not
/// usable count nothing.
Energy system_energy(const SystemModel& model, const CouplingParameters& coupling, const DeviceState& device,
                     const ContactPlanes& contacts, const BodyStates& bodies);

/// The contact part alone, J.
double contact_energy(const SystemModel& model, const ContactPlanes& contacts, const BodyStates& bodies, bool massless);

/// J, what the handle puts in on its way from `before` to `after`, with the coupling's unlimited force at `after`:
///   (k_t (p_WD - p_WT) + b_t (v_WD - v_WT)) . (way of p_WD), and likewise for the rotation where the tool rotates.
double handle_work(const SystemModel& model, const CouplingParameters& coupling, const DeviceState& before,
                   const DeviceState& after, const BodyStates& bodies);

}  // namespace tactor
