#include "nodes/physics/mechanics/touched_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace tactor {

namespace {

constexpr std::size_t most_dofs = 3 * LocalPatch::capacity, most_modes = LocalPatch::most_modes;
// Products of larger ones take memory from the heap.
static_assert(most_dofs * most_modes * sizeof(double) <= EIGEN_STACK_ALLOCATION_LIMIT);

/// The lower triangle of the inverse of L L^T, from the lower triangle of `L`. Rows above a column are never needed, so
/// that it takes half the time of solving for the identity.
void invert(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<Eigen::MatrixXd> inverse) {
  const Eigen::Index n = L.rows();
  constexpr Eigen::Index columns = 24;
  for (Eigen::Index j = 0; j < n; j += columns) {
    const Eigen::Index below = n - j;
    auto block = inverse.block(j, j, below, std::min(columns, below));
    block.setIdentity();
    const auto tail = L.bottomRightCorner(below, below).triangularView<Eigen::Lower>();
    tail.solveInPlace(block);
    tail.adjoint().solveInPlace(block);
  }
}

}  // namespace

TouchedNodes::TouchedNodes()
    : place_(LocalPatch::most_nodes, -1),
      shapes_(most_dofs, most_modes),
      scaled_(most_dofs, most_modes),
      mobility_(most_dofs, most_dofs),
      arrays_(LocalPatch::capacity) {
  arrays_.inertia.resize(most_dofs, most_dofs);
  nodes_.reserve(LocalPatch::capacity);
  known_.reserve(LocalPatch::capacity);
}

void TouchedNodes::take(const LocalPatch& patch, double solved, std::span<SoftContact> contacts) {
  modes_ = static_cast<Eigen::Index>(patch.modes.size());
  nodes_.clear();
  for (SoftContact& contact : contacts) {
    for (std::int32_t& node : contact.node) {
      if (patch.nodes[static_cast<std::size_t>(node)].fixed != 0) {
        node = -1;
        continue;
      }
      std::int32_t& place = place_[static_cast<std::size_t>(node)];
      if (place < 0) {
        place = static_cast<std::int32_t>(nodes_.size());
        nodes_.push_back(node);
      }
      node = place;
    }
  }
  for (const std::int32_t node : nodes_) place_[static_cast<std::size_t>(node)] = -1;
  if (nodes_ != known_ || solved != known_time_) set_inertia(patch, solved);
}

void TouchedNodes::set_inertia(const LocalPatch& patch, double solved) {
  known_ = nodes_;
  known_time_ = solved;
  const Eigen::Map<const Eigen::MatrixXd> all(patch.shapes.data(), static_cast<Eigen::Index>(3 * patch.nodes.size()),
                                              modes_);
  auto shapes = shapes_.topLeftCorner(dofs(), modes_);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    shapes.middleRows<3>(static_cast<Eigen::Index>(3 * i)) =
        all.middleRows<3>(static_cast<Eigen::Index>(3 * nodes_[i]));
  }
  auto scaled = scaled_.topLeftCorner(dofs(), modes_);
  for (std::size_t i = 0; i < patch.modes.size(); ++i) {
    const auto m = static_cast<Eigen::Index>(i);
    scaled.col(m) = std::sqrt(share_kept(patch.modes[i], solved)) * shapes.col(m);
  }
  // The inverse of what an impulse does.
  auto inertia = arrays_.inertia.topLeftCorner(dofs(), dofs());
  auto mobility = mobility_.topLeftCorner(dofs(), dofs());
  mobility.setZero();
  mobility.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(mobility);
  if (factors.info() == Eigen::Success) {
    invert(mobility, inertia);
  } else {
    // Nodes that no force moves. The step will not be solved, and says so.
    inertia.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace tactor
