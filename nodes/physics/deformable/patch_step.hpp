// The step of rigid bodies with the nodes of the patch that they touch.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "nodes/physics/deformable/node_equation.hpp"
#include "nodes/physics/deformable/patch_choice.hpp"
#include "nodes/physics/deformable/step_contacts.hpp"
#include "nodes/physics/deformable/step_factor.hpp"
#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

/// What a step of h seconds is told.
struct StepInput {
  const CouplingParameters& coupling;
  const DeviceState &before, &device;  ///< the handle at the start and the end of the step
  const ContactPlanes& rigid;          ///< the contacts of rigid bodies with each other
  double h;                            ///< s
};

/// Solves the convex problem of contacts: RigidStep with the nodes of the patch, which have the inertia h^2 Schur(A)
/// and, without contacts, the velocities that A^-1 gives them.
class PatchStep {
 public:
  /// Both must outlive it.
  PatchStep(const ElasticModel& model, const PatchChoice& patch);

  /// Moves the bodies from the start of the step, and sets the contact forces of the equation. The step is solved after
  /// `solved` seconds, where the nodes would be at x_free (m, all nodes) without contacts.
  StepResult advance(RigidStep& rigid_step, const StepInput& input, const StepContacts& contacts,
                     const StepFactor& factor, const Eigen::VectorXd& x_free, double solved, NodeEquation& equation,
                     BodyStates& bodies);
  /// Whether the last step had contacts.
  [[nodiscard]] bool touches() const { return !touching_.empty(); }

 private:
  int take_contacts(const std::vector<SoftContact>& found);

  const ElasticModel& model_;
  const PatchChoice& patch_;
  std::vector<SoftContact> touching_;  // in the nodes of the patch
  SoftPatchArrays arrays_;
};

}  // namespace tactor
