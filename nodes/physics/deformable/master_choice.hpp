// Which nodes of deforming surfaces a result is condensed onto, and which of them and their faces it tells.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "nodes/physics/deformable/patch_choice.hpp"
#include "nodes/physics/mechanics/local_patch.hpp"

namespace tactor {

/// The masters: nodes around the tool (PatchChoice), and a few far from it of the same bodies (spread_nodes). Chosen
/// anew where the patch is another.
class MasterChoice {
 public:
  /// Both must outlive it. `far_nodes`: far from the tool, at most.
  MasterChoice(const SoftScene& soft, const PatchChoice& patch, int far_nodes);

  /// True where the masters were chosen anew.
  bool update();

  /// Far from the tool, then around it.
  [[nodiscard]] const std::vector<int>& masters() const { return masters_; }
  [[nodiscard]] Eigen::Index dofs() const { return static_cast<Eigen::Index>(3 * masters_.size()); }
  /// Which of them are of that body.
  [[nodiscard]] std::vector<Eigen::Index> of_body(std::size_t body) const;
  /// The nodes to eliminate last, as a SparseFactor numbers them: those that only other bodies touch, then the masters.
  [[nodiscard]] std::vector<int> last_nodes() const;

  /// What readers are told: nodes around the tool, then those that do not move.
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }
  /// How many of them move.
  [[nodiscard]] std::size_t free() const { return free_; }
  /// Between these nodes.
  [[nodiscard]] const std::vector<PatchFace>& faces() const { return faces_; }

 private:
  void choose_far_nodes();
  void choose_faces();

  const SoftScene& soft_;
  const PatchChoice& patch_;
  std::size_t most_far_;
  std::vector<std::vector<int>> spread_;  // of each body
  bool is_chosen_ = false;
  std::vector<int> chosen_for_;  // the patch's nodes
  std::vector<int> nodes_;
  std::size_t free_ = 0;
  std::vector<int> masters_;
  std::vector<PatchFace> faces_;
};

}  // namespace tactor
