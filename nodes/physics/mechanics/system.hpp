// The moving bodies of a step as plain data, and where a contact plane is once the bodies have moved.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "framework/core/messages.hpp"

namespace tactor {

/// How a step goes from its start to its end (see RigidStep).
enum class Integrator : std::uint8_t { implicit_euler, midpoint };

/// A moving body.
struct BodyModel {
  double mass = 0;                                      ///< kg
  Eigen::Matrix3d inertia_B = Eigen::Matrix3d::Zero();  ///< kg m^2 about its origin (its centre of mass), in its frame
  bool rotates = true;                                  ///< false: 3 degrees of freedom, the orientation stays
};

/// What stays the same from step to step. The bodies stand in the order of Scene::moving(); the first is the tool.
struct SystemModel {
  std::array<BodyModel, max_moving_bodies> body;
  int count = 1;
  Vec3 gravity_W;                ///< m/s^2
  int iterations = 60;           ///< Newton iterations a step, at most
  double tolerance = 1e-9;       ///< of the sum of a body's terms: what may be left of its equation
  double stick_velocity = 1e-4;  ///< m/s, the sliding speed below which friction is viscous
  Integrator integrator = Integrator::implicit_euler;
};

/// The contact planes of one query.
struct ContactPlanes {
  std::span<const Pose> X_WB;  ///< of the moving bodies, for the query
  std::span<const Contact> planes;
  std::span<const ContactPair> pairs;  ///< one a plane
};

/// The planes of a message, which must outlive them.
ContactPlanes contact_planes(const ContactSet& set);

/// A contact plane after the bodies have moved since the query. It moves with the body that it belongs to.
struct PlaneNow {
  Vec3 p_W;             ///< m, the moving body's contact point
  Vec3 n_W;             ///< unit, from the other body towards the moving one
  double distance = 0;  ///< m, negative where they overlap
};

/// True where plane i is finite, of no negative number in its law and a lift of 1 at most, and between bodies that
/// there are.
bool usable(const ContactPlanes& contacts, std::size_t i, int bodies);

/// m/s, of the pair's moving body at the point p_W, m, as the other one sees it. Both must be there.
Vec3 relative_velocity(const BodyStates& bodies, const ContactPair& pair, const Vec3& p_W);

/// Plane i, which must be usable, at the poses `X_WB` of the moving bodies:
///   distance = distance_query + n . (p - p_S),
/// with p_S the point of the other body that was at the moving body's contact point for the query.
PlaneNow plane_now(const ContactPlanes& contacts, std::size_t i, std::span<const Pose> X_WB);

}  // namespace tactor
