// Nodes of deforming surfaces that a step moves together with the rigid bodies that touch them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

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

/// The arrays that a SoftPatch and its motion refer to.
struct SoftPatchArrays {
  /// Room for so many nodes, but for `inertia`.
  explicit SoftPatchArrays(std::size_t most_nodes) : p_W(most_nodes), query_p_W(most_nodes) {
    for (Eigen::VectorXd* v : {&velocity, &free_velocity, &solved_velocity, &force}) {
      v->setZero(static_cast<Eigen::Index>(3 * most_nodes));
    }
  }

  /// The patch of the first n nodes.
  [[nodiscard]] SoftPatch patch(std::size_t n, std::span<const SoftContact> contacts,
                                std::span<const Pose> query_X_WB) const {
    const auto size = static_cast<Eigen::Index>(3 * n);
    return {.p_W = std::span(p_W).first(n),
            .inertia = inertia.topLeftCorner(size, size),
            .velocity = velocity.head(size),
            .free_velocity = free_velocity.head(size),
            .contacts = contacts,
            .query_p_W = std::span(query_p_W).first(n),
            .query_X_WB = query_X_WB};
  }
  [[nodiscard]] SoftPatchMotion motion(std::size_t n) {
    const auto size = static_cast<Eigen::Index>(3 * n);
    return {solved_velocity.head(size), force.head(size)};
  }

  std::vector<Vec3> p_W, query_p_W;  ///< m
  Eigen::MatrixXd inertia;           ///< kg, of the nodes, or larger
  Eigen::VectorXd velocity, free_velocity;
  Eigen::VectorXd solved_velocity, force;  ///< what a step finds
};

}  // namespace tactor
