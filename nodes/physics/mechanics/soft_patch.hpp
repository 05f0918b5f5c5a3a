// Nodes of deforming surfaces that a step moves together with the rigid bodies that touch them.
#pragma once

#include <span>

#include <Eigen/Core>

#include "nodes/physics/contact/soft_contact.hpp"

namespace tactor {

/// n nodes of deforming surfaces over a step of h seconds, in W. Contacts apart, their velocities at the end of the
/// step would be `free_velocity`; an impulse J (N s) changes these by inertia^-1 J. By the midpoint rule both are those
/// over half the step.
struct SoftPatch {
  std::span<const Vec3> p_W;  ///< m, of the nodes at the start of the step, n
  Eigen::Ref<const Eigen::MatrixXd>
      inertia;  ///< kg, 3 n x 3 n, symmetric positive definite; its lower triangle is read
  Eigen::Ref<const Eigen::VectorXd> velocity;       ///< m/s, at the start of the step, 3 n
  Eigen::Ref<const Eigen::VectorXd> free_velocity;  ///< m/s, 3 n
  /// Their nodes count among the n; -1 is one that does not move.
  /// As found with the nodes at `query_p_W` and the bodies at `query_X_WB`, which planes are carried on from.
  std::span<const SoftContact> contacts;
  std::span<const Vec3> query_p_W;
  std::span<const Pose> query_X_WB;
};

/// What a step makes of a patch.
struct SoftPatchMotion {
  Eigen::Ref<Eigen::VectorXd> velocity;  ///< m/s: at the end of the step; by the midpoint rule the mean of the step
  Eigen::Ref<Eigen::VectorXd> force;     ///< N, of the contacts on the nodes, likewise
};

}  // namespace tactor
