// The motion of a patch of deforming surfaces from step to step.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "nodes/physics/contact/soft_contact_source.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"
#include "nodes/physics/mechanics/system.hpp"
#include "nodes/physics/mechanics/touched_nodes.hpp"

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
  [[nodiscard]] bool empty() const { return patch_.nodes.size() == 0; }
  /// m, where the nodes are.
  [[nodiscard]] std::span<const Vec3> nodes_W() const { return std::span(p_W_).first(patch_.nodes.size()); }
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
  [[nodiscard]] Eigen::Index modes() const { return static_cast<Eigen::Index>(patch_.modes.size()); }
  void move_modes(double h);
  void move_by(const Eigen::VectorXd& amounts);
  void place_nodes();

  Integrator integrator_;
  LocalPatch patch_;
  std::vector<Vec3> p_W_, ahead_W_;
  std::vector<std::array<std::int32_t, 3>> face_nodes_;
  std::vector<std::int32_t> face_bodies_;
  std::vector<double> face_areas_;
  Eigen::VectorXd z_, rate_, impulse_;  // by mode; impulse: shape^T J
  Eigen::VectorXd moved_;               // scratch, m or m/s, of the nodes
  TouchedNodes touched_;
};

}  // namespace tactor
