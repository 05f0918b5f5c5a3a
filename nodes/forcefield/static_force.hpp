// The force on a handle that is held still, from the scene's own contacts.
#pragma once

#include "nodes/physics/contact/scene_contacts.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

/// What the coupling's spring shows when it balances the contacts' springs, without friction, weight and dampers:
///   k_t (p_WD - p_WT) + sum k_i max(0, -phi_i(p_WT)) n_i = 0,   F = -k_t (p_WD - p_WT) on the device,
/// in N, W, phi_i the signed distances of the contacts in m. On one wall it is k_t k / (k_t + k) max(0, -phi(p_WD)) n.
///
/// Solved by steps of a massless tool, as dynamics.quasistatic takes them, with the contacts found anew after each. In
/// a groove, whose sides a ball meets one at a time, these do not settle; then by descent along what is left of the
/// balance, in steps that grow shorter (N. Shor, "Minimization Methods for Non-Differentiable Functions", 1985), to
/// about a hundredth of the force. Of several balances it is one that a tool comes to that starts at the handle: deep
/// inside a body, that at the nearest surface, wherever the handle came from.
class StaticForce {
 public:
  /// The scene must suit check_static_scene. `k_t` in N/m; `margin` (m): how near contacts count as near. Finds
  /// contacts as collision.sdf does; throws InputError where that does, and adds its notes.
  StaticForce(const Scene& scene, double k_t, double margin, std::vector<std::string>* notes);

  struct Result {
    Vec3 force;            ///< N
    bool near = false;     ///< there are contacts at p_WD, or distances below the margin
    bool settled = false;  ///< no groove: the last step moved the tool by less than 1 nm
  };
  [[nodiscard]] Result at(const Vec3& p_WD);

 private:
  SceneContacts contacts_;
  RigidStep step_;
  CouplingParameters coupling_;
  Quat R_WT_;
  ContactSet set_;
};

/// Refuses and notes what making a StaticForce does, in less time.
void check_static_force(const Scene& scene, double margin, std::vector<std::string>* notes);

}  // namespace tactor
