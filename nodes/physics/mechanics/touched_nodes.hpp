// The nodes of a patch that contacts touch, as a step sees them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "nodes/physics/mechanics/local_patch.hpp"
#include "nodes/physics/mechanics/soft_patch.hpp"

namespace tactor {

/// The share of its velocity that a mode keeps over h seconds of implicit Euler.
inline double share_kept(const PatchMode& mode, double h) {
  return 1 / (1 + h * mode.damping + h * h * mode.stiffness);
}

/// The shapes and the inertia of the nodes that are touched, in the order in which contacts name them. Both stay for as
/// long as the same nodes are touched over the same time. Allocates nothing after the constructor.
class TouchedNodes {
 public:
  TouchedNodes();

  /// The next `take` is of another patch.
  void forget() { known_time_ = 0; }
  /// Takes the nodes that these contacts touch, over a step that is solved for `solved` seconds. The contacts are told
  /// by those nodes from here on; -1 is a fixed one. Where no force moves some of them the inertia is not a number.
  void take(const LocalPatch& patch, double solved, std::span<SoftContact> contacts);

  /// Their numbers in the patch.
  [[nodiscard]] const std::vector<std::int32_t>& nodes() const { return nodes_; }
  [[nodiscard]] Eigen::Index dofs() const { return static_cast<Eigen::Index>(3 * nodes_.size()); }
  /// 1/sqrt(kg), dofs() rows, a column a mode.
  [[nodiscard]] auto shapes() const { return shapes_.topLeftCorner(dofs(), modes_); }
  /// Of the nodes; `take` sets the inertia.
  [[nodiscard]] SoftPatchArrays& arrays() { return arrays_; }

 private:
  void set_inertia(const LocalPatch& patch, double solved);

  std::vector<std::int32_t> nodes_, place_;  // place_: of each node of the patch among nodes_, or -1
  std::vector<std::int32_t> known_;          // the nodes that shapes_ and the inertia are of
  double known_time_ = 0;                    // s, that the inertia is over; 0: neither is of this patch
  Eigen::Index modes_ = 0;
  Eigen::MatrixXd shapes_, scaled_, mobility_;
  SoftPatchArrays arrays_;
};

}  // namespace tactor
