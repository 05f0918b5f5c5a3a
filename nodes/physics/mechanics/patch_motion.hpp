// The motion of a patch of deforming surfaces from step to step.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "nodes/physics/contact/soft_contact_source.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"
#include "nodes/physics/mechanics/soft_patch.hpp"
#include "nodes/physics/mechanics/system.hpp"

namespace tactor {

/// Goes on with the modes of a LocalPatch. By implicit Euler, over h seconds, with the impulses J = h f of contacts on
/// the nodes, each mode has
///   z'' = D (z' + h (force - stiffness z) + shape^T J),   D = 1 / (1 + h damping + h^2 stiffness),   z <- z + h z'',
/// where z' is its rate before and z'' after. So the nodes' velocities change by sum_i shape_i D_i shape_i^T J, which
/// is exact for the modes, whatever h is. By the midpoint rule the same is solved over h / 2, what is found is the mean
/// rate r, and then z <- z + h r, z'' = 2 r - z'. Allocates nothing after the constructor and throws nothing.
class PatchMotion {
 public:
  explicit PatchMotion(Integrator integrator);

  /// Goes on from there. `patch` must be usable.
  void restart(const LocalPatch& patch);
  [[nodiscard]] bool empty() const { return nodes_ == 0; }
  /// m, where the nodes are.
  [[nodiscard]] std::span<const Vec3> nodes_W() const { return std::span(p_W_).first(nodes_); }
  [[nodiscard]] SoftFaces faces() const;
  /// s, of a step of h seconds until its forces act: h, or half of it by the midpoint rule.
  [[nodiscard]] double solved_time(double h) const { return integrator_ == Integrator::midpoint ? h / 2 : h; }
  /// m, where their velocities take the nodes until the forces of a step of h seconds act. Valid until the nodes move.
  std::span<const Vec3> nodes_ahead_W(double h);

  /// The nodes that these contacts touch, as a step over h seconds sees them; the contacts are told by those nodes from
  /// here on. They were found with the bodies at X_WB, and with the nodes where nodes_ahead_W had them since the nodes
  /// last moved, or else where they are. Valid until the next call. Where no force moves some of them, as of shapes
  /// that are zero, the inertia is not a number, and no step is solved with it.
  SoftPatch begin(double h, std::span<SoftContact> contacts, std::span<const Pose> X_WB);
  /// Where the step puts velocities and forces of the nodes that `begin` named.
  SoftPatchMotion motion();
  /// Takes the step of h seconds that `begin` was told of, with the forces in `motion`.
  void end(double h);
  /// The same step without contacts.
  void coast(double h);

  /// The patch as it is now, into modes of a pool's array: writes z and rate of each.
  void write(std::span<PatchMode> modes) const;

 private:
  [[nodiscard]] double free_rate(std::size_t mode, double h) const;
  void set_inertia(double solved);
  void move_modes(double h);
  void place_nodes();

  Integrator integrator_;
  LocalPatch patch_;
  std::size_t nodes_ = 0;
  Eigen::Index modes_ = 0;
  std::vector<Vec3> p_W_, ahead_W_;
  std::vector<std::array<std::int32_t, 3>> face_nodes_;
  std::vector<std::int32_t> face_bodies_;
  std::vector<double> face_areas_;
  Eigen::VectorXd z_, rate_, impulse_;  // by mode; impulse: shape^T J
  // Of the nodes that are touched, in the order in which contacts name them.
  std::vector<std::int32_t> touched_, place_;  // their numbers; of each node, its place among them or -1
  std::vector<std::int32_t> known_touched_;    // the nodes that shapes_ and inertia_ are of
  double known_time_ = 0;                      // s, that inertia_ is over; 0: neither is of this patch
  std::vector<Vec3> touched_p_W_, touched_ahead_W_;
  Eigen::MatrixXd shapes_, scaled_, mobility_, inertia_;
  Eigen::VectorXd velocity_, free_velocity_, velocity_after_, force_;
};

}  // namespace tactor
